# %% [markdown]
# # Read the data with pandas
#
# Every episode is kept, as a Parquet dataset: one file an episode, in folders by scenario and
# controller. Any tool reads it as one table. It needs `pip install '.[evaluate]' pandas`.

# %%
import os
import subprocess
import sys
from pathlib import Path

import pandas as pd

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
OUT = Path(os.environ.get("SWARM_FORAGE_OUT", "runs/tutorials")) / "data"

# %% [markdown]
# ## Make some
#
# On the command line: `swarm-forage evaluate es1 nc ssgikf ssgiff:beta=0.001 ssgiff:beta=0.1
# --out runs/tutorials/data`

# %%
names = ["nc", "ssgikf", "ssgiff:beta=0.001", "ssgiff:beta=0.1"]
budget = ["--episodes=2", "--set=task.duration=120", "--workers=1"] if SMALL else ["--episodes=30"]
command = [sys.executable, "-m", "training.cli", "evaluate", "es1", *names, f"--out={OUT}"]
subprocess.run([*command, *budget, "--format=csv"], check=True, stdout=subprocess.DEVNULL)

# %% [markdown]
# ## Read it
#
# The folders `scenario=` and `controller=` become columns. `parameters` holds, as JSON, the
# numbers of the controller that were asked for.

# %%
episodes = pd.read_parquet(OUT)
print(episodes.shape)
print(sorted(episodes.columns))

# %% [markdown]
# ## Ask it
#
# Means by controller; `beta` is taken out of the parameters.

# %%
import json

episodes["controller"] = episodes["controller"].astype(str)
episodes["beta"] = [json.loads(each).get("weighting.beta") for each in episodes["parameters"]]
columns = ["round_trips", "on_path_share", "lost_events", "localisation_error_m"]
print(episodes.groupby(["controller", "beta"], dropna=False)[columns].mean().round(3))

# %% [markdown]
# Seeds are paired across controllers, so differences can be taken world by world:

# %%
without_beta = episodes[episodes["controller"].isin(["nc", "ssgikf"])]
paired = without_beta.pivot(index="seed", columns="controller", values="round_trips")
print((paired["ssgikf"] - paired["nc"]).describe().round(1))

# %% [markdown]
# Where every robot was in every tick is kept too, if it is asked for, in a folder beside the other.

# %%
few = [sys.executable, "-m", "training.cli", "evaluate", "es1", "ssgikf", f"--out={OUT}-few"]
few += ["--episodes=1", "--trajectories", "--format=csv", "--workers=1"]
few += ["--set=task.duration=120"] if SMALL else []
subprocess.run(few, check=True, stdout=subprocess.DEVNULL)
rows = pd.read_parquet(
    f"{OUT}-few-trajectories", columns=["t", "robot", "known_nest", "known_prey"]
)
rows["on_path"] = rows["known_nest"] & rows["known_prey"]
print(rows.groupby(rows["t"] // 60 * 60)["on_path"].mean().round(2))

# %% [markdown]
# polars and DuckDB read the same folder:
# `duckdb.sql("select controller, avg(round_trips) from 'runs/es1/**/*.parquet' group by all")`.
