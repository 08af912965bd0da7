# %% [markdown]
# # Reproduce a figure of a paper and change one thing
#
# Figures 14 and 15 of the technical report of 2009 compare strategies by their round trips. This
# tutorial runs three of them in `es1`, the first world of the paper, draws them beside the
# published numbers, and then changes the range of the radio. It takes some minutes and needs
# `pip install '.[evaluate]'`.
#
# `swarm-forage reproduce social-odometry` makes all figures and checks all claims of the report, in
# hours.

# %%
import matplotlib.pyplot as plt
import numpy as np

from baselines.evaluation.episode import run_episodes
from baselines.evaluation.statistics import mann_whitney_p, mean_interval
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller

# %% tags=["parameters"]
EPISODES = 15
CHANGES = {}  # of the scenario; none: the world of the paper

# %% [markdown]
# ## Run
#
# `nc` does not communicate. `ssgikf` is the induced Kalman filter. `ssgiff` weighs by a Fermi
# function of the difference between the paths of both robots, and beta is its steepness. The report
# gives the best beta to a decade; those of 1e-5 to 1e-3 cannot be told apart here.

# %%
PUBLISHED = {"nc": 60, "ssgikf": 150, "ssgiff:beta=0.001": 170}


def round_trips(changes):
    """The round trips of each strategy in a changed world, an episode for each seed."""
    scenario = find_scenario("es1", {**CHANGES, **changes})
    return {
        name: [
            e.round_trips for e in run_episodes(scenario, find_controller(name), range(EPISODES))
        ]
        for name in PUBLISHED
    }


trips = round_trips({})

# %% [markdown]
# ## Compare
#
# Every mean has a 95 % bootstrap interval over episodes. A Mann-Whitney test compares each strategy
# with `nc`.


# %%
def table(trips):
    """Print a line for each strategy."""
    for name, own in trips.items():
        estimate, p = mean_interval(own), mann_whitney_p(own, trips["nc"])
        low, high = estimate.interval or (estimate.value, estimate.value)
        print(f"{name:18} {estimate.value:6.1f} ({low:.0f} to {high:.0f})", end="")
        print("" if name == "nc" else f", p {p:.2g} against nc")


table(trips)

# %% [markdown]
# ## Draw

# %%
figure, axes = plt.subplots(figsize=(6.0, 2.8), layout="constrained")
axes.boxplot(list(trips.values()), orientation="horizontal", tick_labels=list(trips))
axes.plot(list(PUBLISHED.values()), np.arange(1, 4), "D", label="published")
axes.set_xlabel("round trips in half an hour")
_ = axes.legend()

# %% [markdown]
# The order and the sizes hold in `es1`. 32 of the 45 claims of the report hold; [social
# odometry](../papers/social_odometry.md) lists each of them, with what was tried for the rest.
#
# ## Change one thing
#
# Any number of a scenario can be changed by its dotted name; `swarm-forage list es1` prints them
# all. Here the radio reaches 5, 15 (the published range) and 30 cm, on the same seeds.

# %%
RANGES = (0.05, 0.15, 0.30)
by_range = {
    metres: trips if metres == 0.15 else round_trips({"radio.max_range": metres})
    for metres in RANGES
}

figure, axes = plt.subplots(figsize=(6.0, 3.2), layout="constrained")
for name in PUBLISHED:
    estimates = [mean_interval(by_range[metres][name]) for metres in RANGES]
    means = np.array([each.value for each in estimates])
    ends = np.array([each.interval or (each.value, each.value) for each in estimates]).T
    axes.errorbar(RANGES, means, np.abs(ends - means), marker="o", capsize=3, label=name)
axes.set(xlabel="range of the radio [m]", ylabel="round trips in half an hour", ylim=(0, None))
_ = axes.legend()

# %%
table(by_range[0.30])

# %% [markdown]
# On the command line: `swarm-forage evaluate es1 nc ssgikf --set radio.max_range=0.3`, and
# `swarm-forage plot curve` over the folders of several such runs.
