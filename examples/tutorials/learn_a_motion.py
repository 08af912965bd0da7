# %% [markdown]
# # Learn a motion from scratch
#
# PPO of stable-baselines3 learns how all robots steer, starting from nothing. One network is
# shared; every robot of every world is an environment to it. With 6 million robot-steps this
# takes a minute on two cores and needs `pip install '.[train]'`.

# %%
import os
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller
from training.vec_env import SwarmVecEnv

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
ROBOT_STEPS = 20_000 if SMALL else 6_000_000
OUT = Path(os.environ.get("SWARM_FORAGE_OUT", "runs/tutorials"))
OUT.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The environment
#
# The defaults: an action is a speed and a turn, held for a second (`decision_period=10` ticks); a
# robot without a goal is shown the course of its random walk; it stands while it talks and goes
# round what is near by itself; and it earns 1 for each round trip, nothing else.

# %%
PERIOD = 10
torch.set_num_threads(1)  # quicker for networks this small
env = SwarmVecEnv("es1", n_worlds=2 if SMALL else 8)
print(env.num_envs, "rows,", env.observation_space.shape, env.action_space.shape)

# %% [markdown]
# ## Train

# %%
model = PPO(
    "MlpPolicy",
    env,
    n_steps=128,
    batch_size=640 if SMALL else 1024,
    seed=1,
    device="cpu",
)
model.learn(ROBOT_STEPS // PERIOD)
file = OUT / "motion.zip"
model.save(file)

# %% [markdown]
# ## Evaluate
#
# A saved model is a controller by name; with `chance=true` it acts with the noise that it was
# trained with. The seeds from 1000 on are worlds that the training has not met. One training is
# one sample, so report several seeds ([the ladder](../ladder.md)).

# %%
scenario = find_scenario("es1", {"task.duration": 120.0} if SMALL else {})
for name in ("ssgikf", f"sb3:{file}", f"sb3:{file},chance=true"):
    found = run_episodes(scenario, find_controller(name), range(1000, 1001 if SMALL else 1005))
    print(f"{name:45} {np.mean([episode.round_trips for episode in found]):6.1f} round trips")

# %% [markdown]
# ```sh
# swarm-forage evaluate es1 nc ssgikf sb3:runs/tutorials/motion.zip
# swarm-forage watch es1 sb3:runs/tutorials/motion.zip --html motion.html
# ```
#
# Next: [learn a weighting](learn_a_weighting.md).
