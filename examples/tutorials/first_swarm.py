# %% [markdown]
# # First swarm
#
# Ten robots, a nest and a prey area. This tutorial makes the environment, looks at what a robot
# observes, lets robots drive at random, and sets two hand-written controllers beside that. It
# takes a minute or two, half of it for compiling, once. It needs `pip install .`, the core.

# %%
import os

import numpy as np

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import find_scenario, parallel_env
from swarm_forage_env.controllers import find_controller

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
SECONDS = 120.0 if SMALL else 1800.0
EPISODES = 1 if SMALL else 5

# %% [markdown]
# ## The environment
#
# `learn="motion"` says that a policy steers the robots; the rest of each robot (what it believes,
# how it talks) is the hand-written controller `ssgikf`. All robots act in each step; a step is
# one second, ten ticks.

# %%
env = parallel_env("es1", learn="motion", **{"task.duration": SECONDS})
observations, infos = env.reset(seed=0)
print(len(env.agents), "robots,", env.max_cycles, "steps in an episode")
print(env.action_layout)

# %% [markdown]
# An observation is 45 numbers in the robot's own frame. The layout names each of them. Of what a
# robot has not found yet, the numbers are 0 and the flag `known` is 0.

# %%
seen = dict(zip(env.observation_layout.names, observations["epuck_0"].tolist(), strict=True))
for name in ("situation.ground.middle", "situation.known.nest", "situation.target.x"):
    print(f"{name:28} {seen[name]:.2f}")

# %% [markdown]
# ## Driving at random

# %%
rng = np.random.default_rng(0)
while env.agents:
    actions = {agent: rng.uniform(-1.0, 1.0, 2).astype(np.float32) for agent in env.agents}
    observations, rewards, terminations, truncations, infos = env.step(actions)
print("random:", sum(info["round_trips"] for info in infos.values()), "round trips")

# %% [markdown]
# ## Two hand-written controllers
#
# In `nc` robots tell each other nothing. In `ssgikf` a robot that meets another blends its
# estimate with the one it hears. Seeds are paired: both controllers meet the same worlds.

# %%
scenario = find_scenario("es1", {"task.duration": SECONDS})
trips = {}
for name in ("nc", "ssgikf"):
    episodes = run_episodes(scenario, find_controller(name), seeds=range(EPISODES))
    trips[name] = [episode.round_trips for episode in episodes]
    print(f"{name:7} {np.mean(trips[name]):6.1f} round trips, {trips[name]}")

# %% [markdown]
# Over half an hour, talking more than doubles what the swarm brings in. To see why, watch a
# robot's belief: `swarm-forage watch es1 ssgikf --html es1.html`, then choose a robot in the
# page. Next: [learn a motion from scratch](learn_a_motion.md).
