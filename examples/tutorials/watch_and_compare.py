# %% [markdown]
# # Watch and compare
#
# A score says that a controller is better, a picture says why. This tutorial writes a replay of two
# controllers in the same world, a map of where their robots drove, and a figure of how far each
# believes what it receives. It takes a minute and needs `pip install '.[render]'`.

# %%
import subprocess
import sys
from pathlib import Path

from PIL import Image

# %% tags=["parameters"]
SECONDS = 300  # of the replay

# %%
OUT = Path("runs/tutorials")
OUT.mkdir(parents=True, exist_ok=True)


def swarm_forage(*arguments):
    """Run the command line."""
    subprocess.run([sys.executable, "-m", "training.cli", *map(str, arguments)], check=True)


# %% [markdown]
# ## A replay
#
# A replay is one file that any browser plays without a network. It shows two controllers side by
# side in the same world. Select a robot: dashed circles mark where it believes nest and prey to be,
# and a ring shows p, the path since it left that area, as its uncertainty.

# %%
file = OUT / "nc-and-ssgikf.html"
swarm_forage("watch", "es1", "nc", "ssgikf", "--seed=1", "--seconds", SECONDS, "--html", file)
print(f"{file}: {file.stat().st_size / 1e6:.1f} MB for {SECONDS} s of two swarms")

# %% [markdown]
# A still of the same world at the end of these seconds:

# %%
still = ["--seed=1", "--start", SECONDS - 1, "--select=7", "--size=480", "--frame", OUT / "es1.png"]
swarm_forage("watch", "es1", "ssgikf", *still)
Image.open(OUT / "es1.png")

# %% [markdown]
# ## Where they drove

# %%
swarm_forage("plot", "paths", "es1", "nc", "ssgikf", "--out", OUT / "paths.png")
Image.open(OUT / "paths.png")

# %% [markdown]
# ## How far each believes what it receives
#
# The own path is on one axis and the received one on the other; the colour is g, by the rules of
# the papers.

# %%
swarm_forage("plot", "weights", "ssgikf", "ssgiff", "--out", OUT / "weights.png")
Image.open(OUT / "weights.png")

# %% [markdown]
# `swarm-forage watch es1 ssgikf` opens a window, `--video es1.mp4` (or `.gif`) writes a clip and
# `--frame x.png` a still. In code, `parallel_env("es1", render_mode="rgb_array")` renders by
# `env.render()` after a reset.
