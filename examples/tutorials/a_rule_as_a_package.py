# %% [markdown]
# # Write your own rule as a package
#
# `swarm-forage` finds a weighting rule of your package by its name, on the command line, in
# environments and in datasets. The package has two files. This tutorial writes them, installs them
# into a folder, and evaluates the rule. It takes a minute and needs `pip install '.[evaluate]'`.

# %%
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

# %% tags=["parameters"]
BUDGET = ["--episodes=30"]
PIP = []  # further options of pip install

# %%
OUT = Path("runs/tutorials")
FOLDER = OUT / "hopeful-swarm"
FOLDER.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The rule
#
# The decorator enters the class into the registry. The rule is called with the exchanges of all
# robots: arrays with a row for each robot and a column for each of nest and prey.

# %%
RULE = '''"""A weighting rule: believe the nearer of two places."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.parameters import Parameters, Share


@WEIGHTING_RULES.register("hopeful")
class Hopeful(Parameters):
    """Move towards the received place by a share where it is nearer. Source: a tutorial."""

    heard_p_share: ClassVar[float] = 1.0

    trust: Share = Field(0.8, description="Weight of a nearer place (chosen)")

    def __call__(self, exchange):
        """The weight of each row and area."""
        is_nearer = exchange.heard_distance < exchange.own_distance
        return np.where(is_nearer, np.float32(self.trust), np.float32(0.0))
'''
_ = (FOLDER / "hopeful_swarm.py").write_text(RULE, encoding="utf-8")

# %% [markdown]
# ## The package
#
# The entry point names the module that `swarm-forage` imports when it meets a name that it does not
# know.

# %%
PROJECT = """[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "hopeful-swarm"
version = "0.1.0"
dependencies = ["swarm-forage"]

[project.entry-points."swarm_forage_env.controllers"]
hopeful = "hopeful_swarm"

[tool.hatch.build.targets.wheel]
only-include = ["hopeful_swarm.py"]
"""
_ = (FOLDER / "pyproject.toml").write_text(PROJECT, encoding="utf-8")

# %% [markdown]
# ## Install it
#
# Usually `pip install ./hopeful-swarm`. Here pip installs it into a separate folder, so that your
# environment does not change.

# %%
site = OUT / "hopeful-site"
install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--upgrade", *PIP]
_ = subprocess.run([*install, "--target", str(site), str(FOLDER)], check=True)

# %% [markdown]
# The rule by itself: its weight for two exchanges, in which the received place is nearer than the
# own one, and farther.

# %%
sys.path.insert(0, str(site))
from types import SimpleNamespace

from hopeful_swarm import Hopeful

distances = SimpleNamespace(heard_distance=np.array([0.4, 1.2]), own_distance=np.array([0.9, 0.9]))
print(Hopeful(trust=0.9)(distances))

# %% [markdown]
# ## Evaluate it
#
# The name of a composed controller is `estimator+weighting+motion`. Parameters follow a colon.

# %%
path = os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")])


def swarm_forage(*arguments):
    """Run the command line with the package on its path, and print what it prints."""
    command = [sys.executable, "-m", "training.cli", *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": path}
    run = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    print(run.stdout)


rule = "social_odometry+hopeful+subsumption:trust=0.9"
plot = OUT / "hopeful.png"
swarm_forage(
    "evaluate", "es1", "ssgikf", rule, *BUDGET, "--out", OUT / "hopeful-data", "--plot", plot
)

# %%
Image.open(plot)

# %% [markdown]
# In an installed package, the command is
# `swarm-forage evaluate es1 ssgikf social_odometry+hopeful+subsumption:trust=0.9`. A compiled rule
# runs faster: [a weighting rule of your own](../guides/weighting.md#compiled).
