# %% [markdown]
# # Write your own rule as a package
#
# A weighting rule in a package of yours is found by name wherever `swarm-forage` looks: command
# line, environments, datasets. The package is two files. This tutorial writes them, installs them
# into a folder, and evaluates the rule. It needs `pip install '.[evaluate]'`.

# %%
import os
import subprocess
import sys
from pathlib import Path

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
OUT = Path(os.environ.get("SWARM_FORAGE_OUT", "runs/tutorials"))
FOLDER = OUT / "hopeful-swarm"
FOLDER.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The rule
#
# The class enters the registry by its decorator. It is called with the exchanges of all robots;
# the arrays have a row for each robot and a column for nest and prey.

# %%
RULE = '''"""A weighting rule: believe the nearer of two places."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.parameters import Parameters, Share


@WEIGHTING_RULES.register("hopeful")
class Hopeful(Parameters):
    """Take the heard place, to a share, where it is nearer than the own one. Source: a tutorial."""

    heard_p_share: ClassVar[float] = 1.0

    trust: Share = Field(0.8, description="Weight of a nearer place (chosen)")

    def __call__(self, exchange):
        """The weight of each row and area."""
        is_nearer = exchange.heard_distance < exchange.own_distance
        return np.where(is_nearer, np.float32(self.trust), np.float32(0.0))
'''
(FOLDER / "hopeful_swarm.py").write_text(RULE, encoding="utf-8")

# %% [markdown]
# ## The package
#
# The entry point tells `swarm-forage` which module to import when a name is asked for that it
# does not know.

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
(FOLDER / "pyproject.toml").write_text(PROJECT, encoding="utf-8")

# %% [markdown]
# ## Install it
#
# Usually `pip install ./hopeful-swarm`. Here it goes into a folder of its own, so that nothing is
# left in your environment.

# %%
site = OUT / "hopeful-site"
install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--upgrade"]
offline = ["--no-build-isolation"] if SMALL else []
subprocess.run([*install, *offline, "--target", str(site), str(FOLDER)], check=True)

# %% [markdown]
# ## Evaluate it
#
# A controller is an estimator, a weighting and a motion, joined by `+`; parameters follow a
# colon.

# %%
path = os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")])
budget = ["--episodes=1", "--set=task.duration=120", "--workers=1"] if SMALL else ["--episodes=30"]
names = ["ssgikf", "social_odometry+hopeful+subsumption:trust=0.9"]
command = [sys.executable, "-m", "training.cli", "evaluate", "es1", *names]
subprocess.run(
    [*command, *budget, f"--out={OUT / 'hopeful-data'}"],
    check=True,
    env={**os.environ, "PYTHONPATH": path},
)

# %% [markdown]
# In an installed package, that is
# `swarm-forage evaluate es1 ssgikf social_odometry+hopeful+subsumption:trust=0.9`. A rule that is
# compiled runs faster: [a weighting rule of your own](../guides/weighting.md#compiled).
