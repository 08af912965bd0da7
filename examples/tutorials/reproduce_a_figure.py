# %% [markdown]
# # Reproduce a figure of a paper
#
# Figures 14 and 15 of the technical report of 2009 compare strategies by round trips. Here three of
# them run in the first world of the paper, `es1`, and are drawn beside the published numbers. It
# needs `pip install '.[evaluate]'`; with 30 episodes each it takes some minutes.
#
# One command does all figures and all claims: `swarm-forage reproduce social-odometry` (hours).

# %%
import os
from pathlib import Path

import matplotlib
import numpy as np

from baselines.evaluation.episode import run_episodes
from baselines.evaluation.statistics import mann_whitney_p, mean_interval
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller

matplotlib.use("agg")
from matplotlib import pyplot as plt

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
EPISODES = 2 if SMALL else 30
CHANGES = {"task.duration": 120.0, "task.area_distance": 0.7} if SMALL else {}
OUT = Path(os.environ.get("SWARM_FORAGE_OUT", "runs/tutorials"))
OUT.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## Run
#
# `nc` is no communication, `ssgikf` the induced Kalman filter. `ssgiff` weighs by a Fermi function
# of the difference between the paths of both robots; beta is its steepness. The papers give the
# best beta to a decade; 0.001 per centimetre is the best one here.

# %%
PUBLISHED = {"nc": 60, "ssgikf": 150, "ssgiff:beta=0.001": 170}

scenario = find_scenario("es1", CHANGES)
trips = {
    name: [e.round_trips for e in run_episodes(scenario, find_controller(name), range(EPISODES))]
    for name in PUBLISHED
}

# %% [markdown]
# ## Compare
#
# Every number comes with a 95 % bootstrap interval over episodes, and strategies are compared by
# a Mann-Whitney test.

# %%
for name, own in trips.items():
    estimate, p = mean_interval(own), mann_whitney_p(own, trips["nc"])
    low, high = estimate.interval or (estimate.value, estimate.value)
    print(f"{name:18} {estimate.value:6.1f} ({low:.0f} to {high:.0f}),", end=" ")
    print(f"published {PUBLISHED[name]}, p {p:.2g}")

# %% [markdown]
# ## Draw

# %%
figure, axes = plt.subplots(figsize=(5.0, 3.2), layout="constrained")
axes.boxplot(list(trips.values()), orientation="horizontal", tick_labels=list(trips))
if not SMALL:
    axes.plot(list(PUBLISHED.values()), np.arange(1, 4), "D", label="published")
    axes.legend()
axes.set_xlabel("Round trips in half an hour")
figure.savefig(OUT / "strategies.png", dpi=150)
print("wrote", OUT / "strategies.png")

# %% [markdown]
# The order and the sizes hold in `es1`. Not every claim does: 25 of 38 in this report, each
# listed in [social odometry](../papers/social_odometry.md) with what was tried for the rest.
