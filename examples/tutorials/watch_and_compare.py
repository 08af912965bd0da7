# %% [markdown]
# # Watch and compare
#
# Scores say that a controller is better; pictures say why. This tutorial writes a replay of two
# controllers in the same world, a map of where their robots drove, and a figure of how far each
# believes what it hears. It needs `pip install '.[render]'`.

# %%
import os
import subprocess
import sys
from pathlib import Path

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
OUT = Path(os.environ.get("SWARM_FORAGE_OUT", "runs/tutorials"))
OUT.mkdir(parents=True, exist_ok=True)


def swarm_forage(*arguments):
    """Run the command line."""
    subprocess.run([sys.executable, "-m", "training.cli", *map(str, arguments)], check=True)


# %% [markdown]
# ## A replay
#
# One file that any browser plays, without a network: two controllers side by side, in the same
# world. Choose a robot: dashed circles show where it believes nest and prey to be, and a ring how
# unsure it is.

# %%
file, seconds = OUT / "nc-and-ssgikf.html", 20 if SMALL else 300
swarm_forage("watch", "es1", "nc", "ssgikf", "--seed=1", "--seconds", seconds, "--html", file)

# %% [markdown]
# ## Where they drove

# %%
swarm_forage("plot", "paths", "es1", "nc", "ssgikf", "--out", OUT / "paths.png")

# %% [markdown]
# ## How far each believes what it hears
#
# The own path on one axis, the heard one on the other, g as colour: the rules of the papers.

# %%
swarm_forage("plot", "weights", "ssgikf", "ssgiff", "--out", OUT / "weights.png")

# %% [markdown]
# There are windows and videos too: `swarm-forage watch es1 ssgikf` opens a window,
# `--video es1.mp4` or `.gif` writes a clip, `--frame x.png` a still. In code,
# `parallel_env("es1", render_mode="rgb_array")` and `env.render()` after a reset.
