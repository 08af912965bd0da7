# %% [markdown]
# # First swarm
#
# Ten robots, a nest and a prey area. This tutorial makes the environment, prints what a robot
# observes, drives the robots at random, and compares that with two hand-written controllers. It
# takes a minute, half of it for compiling once, and needs `pip install '.[render]'`.

# %%
import matplotlib.pyplot as plt
import numpy as np

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import find_scenario, parallel_env
from swarm_forage_env.controllers import find_controller

# %% tags=["parameters"]
SECONDS = 1800.0  # of an episode
EPISODES = 10

# %% [markdown]
# ## The environment
#
# `learn="motion"` means that a policy steers the robots. The other layers of each robot, its
# estimates and its messages, stay those of the hand-written controller `ssgikf`. All robots act in
# each step. A step is one second, which is ten ticks.

# %%
env = parallel_env("es1", learn="motion", **{"task.duration": SECONDS})
observations, infos = env.reset(seed=0)
print(len(env.agents), "robots,", env.max_cycles, "steps in an episode")
print(env.action_layout)

# %% [markdown]
# An observation has 45 features in the robot's own frame, and the layout names each of them.
# Features of an area that the robot has not found are 0, and so is their flag `known`.

# %%
observed = dict(zip(env.observation_layout.names, observations["epuck_0"].tolist(), strict=True))
for name in ("situation.ground.middle", "situation.known.nest", "situation.target.x"):
    print(f"{name:28} {observed[name]:.2f}")

# %% [markdown]
# ## Random actions
#
# A notebook shows an environment as a picture with its facts: here the world after a random
# episode.

# %%
rng = np.random.default_rng(0)
while env.agents:
    actions = {agent: rng.uniform(-1.0, 1.0, 2).astype(np.float32) for agent in env.agents}
    observations, rewards, terminations, truncations, infos = env.step(actions)
random_trips = int(sum(info["round_trips"] for info in infos.values()))
print("random actions:", random_trips, "round trips")
env

# %% [markdown]
# ## Two hand-written controllers
#
# `nc` does not communicate. `ssgikf` blends its own estimate with the one that it receives. Seeds
# are paired: both controllers meet the same worlds.

# %%
scenario = find_scenario("es1", {"task.duration": SECONDS})
trips = {}
for name in ("nc", "ssgikf"):
    episodes = run_episodes(scenario, find_controller(name), seeds=range(EPISODES))
    trips[name] = [episode.round_trips for episode in episodes]
    print(f"{name:7} {np.mean(trips[name]):6.1f} round trips, {trips[name]}")

# %%
figure, axes = plt.subplots(figsize=(6.0, 2.4), layout="constrained")
axes.boxplot(list(trips.values()), orientation="horizontal", tick_labels=list(trips))
axes.axvline(random_trips, linestyle="--", color="0.4", label="random actions, one episode")
axes.set_xlabel("round trips in an episode")
_ = axes.legend()

# %% [markdown]
# Communication more than doubles the round trips of half an hour. To see why, watch the belief of a
# robot: `swarm-forage watch es1 ssgikf --html es1.html`, then select a robot in the page. Next:
# [train in 20 lines](train_in_20_lines.md).
