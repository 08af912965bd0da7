# %% [markdown]
# # Read the data with pandas
#
# `swarm-forage evaluate` keeps every episode in a Parquet dataset: one file for each episode, in
# folders by scenario and controller. Any tool reads the dataset as one table. This tutorial takes
# some minutes and needs `pip install '.[evaluate]' pandas`.

# %%
import json
import subprocess
import sys
import textwrap

import matplotlib.pyplot as plt
import pandas as pd

# %% tags=["parameters"]
BUDGET = ["--episodes=30"]
FEW = ["--episodes=1"]  # with trajectories
OUT = "runs/tutorials/data"


# %%
def evaluate(*arguments):
    """Run `swarm-forage evaluate`; its summary is not needed here."""
    command = [sys.executable, "-m", "training.cli", "evaluate", "es1", *arguments, "--format=csv"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


# %% [markdown]
# ## Make a dataset
#
# The command line is
# `swarm-forage evaluate es1 nc ssgikf ssgiff:beta=0.001 ssgiff:beta=0.1 --out runs/tutorials/data`.

# %%
evaluate("nc", "ssgikf", "ssgiff:beta=0.001", "ssgiff:beta=0.1", f"--out={OUT}", *BUDGET)

# %% [markdown]
# ## Read it
#
# The folders `scenario=` and `controller=` become columns. `parameters` holds the parameters that
# were set in the controller's name, as JSON.

# %%
episodes = pd.read_parquet(OUT)
print(episodes.shape)
print(textwrap.fill(", ".join(sorted(episodes.columns)), 90))

# %% [markdown]
# ## Means by controller
#
# `beta` is read from the parameters.

# %%
episodes["controller"] = episodes["controller"].astype(str)
episodes["beta"] = [json.loads(each).get("weighting.beta") for each in episodes["parameters"]]
columns = ["round_trips", "on_path_share", "lost_events", "localisation_error_m"]
print(episodes.groupby(["controller", "beta"], dropna=False)[columns].mean().round(3))

# %% [markdown]
# ## Differences by seed
#
# Seeds are paired across controllers, so that differences are taken world by world.

# %%
without_beta = episodes[episodes["controller"].isin(["nc", "ssgikf"])]
paired = without_beta.pivot(index="seed", columns="controller", values="round_trips")
print((paired["ssgikf"] - paired["nc"]).describe().round(1))

# %%
figure, axes = plt.subplots(figsize=(4.2, 3.6), layout="constrained")
axes.plot(paired["nc"], paired["ssgikf"], "o")
_ = axes.set(xlabel="round trips of nc", ylabel="round trips of ssgikf in the same world")

# %% [markdown]
# ## Trajectories
#
# With `--trajectories` the pose and the belief of every robot in every tick are kept in a second
# folder. The share of robots that know both areas, by minute:

# %%
evaluate("ssgikf", f"--out={OUT}-few", "--trajectories", "--workers=1", *FEW)
columns = ["t", "robot", "known_nest", "known_prey"]
rows = pd.read_parquet(f"{OUT}-few-trajectories", columns=columns)
rows["on_path"] = rows["known_nest"] & rows["known_prey"]
by_minute = rows.groupby(rows["t"] // 60)["on_path"].mean()
print(by_minute.head(8).round(2))

# %%
figure, axes = plt.subplots(figsize=(6.0, 2.6), layout="constrained")
axes.plot(by_minute)
_ = axes.set(xlabel="minute", ylabel="share of robots on the path", ylim=(0, 1))

# %% [markdown]
# polars and DuckDB read the same folder. It may hold a controller with several parameters, changes
# of the scenario (`overrides`), engines and versions of the code, which a mean must not mix:
# `duckdb.sql("select controller, parameters, overrides, physics, code, avg(round_trips) from
# 'runs/es1/**/*.parquet' group by all")`.
