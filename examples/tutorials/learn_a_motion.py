# %% [markdown]
# # Learn a motion from scratch
#
# PPO of stable-baselines3 learns to steer all robots from random weights. The robots share one
# network, and every robot of every world is one environment of it. Six million robot-steps take a
# minute on two cores. It needs `pip install '.[train]'`.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller
from training.vec_env import SwarmVecEnv

# %% tags=["parameters"]
ROBOT_STEPS = 6_000_000
N_WORLDS = 8
BATCH = 1024
TEST_SEEDS = range(1000, 1010)  # worlds that the training does not meet
CHANGES = {}  # of the scenario
FOLDER = "runs/tutorials"

# %% [markdown]
# ## The environment
#
# The defaults: an action is a speed and a turn, held for a second (`decision_period=10` ticks). A
# robot without a goal observes the direction of its random walk. The hand-written reflexes stop a
# robot while it talks and steer it around obstacles. The reward is 1 for each round trip.

# %%
PERIOD = 10
torch.set_num_threads(1)  # faster for networks of this size
env = SwarmVecEnv("es1", n_worlds=N_WORLDS, stagger=True, **CHANGES)
print(env.num_envs, "rows,", env.observation_space.shape, env.action_space.shape)

# %% [markdown]
# ## Train
#
# A callback sums the rewards of each rollout, as they would come to in an episode of the swarm.


# %%
class Curve(BaseCallback):
    """The round trips of each rollout, as a rate of an episode."""

    def _on_training_start(self):
        (self.episode,) = set(self.training_env.get_attr("max_cycles"))
        self.robot_steps, self.trips = [], []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        rewards = self.model.rollout_buffer.rewards
        robots = self.training_env.num_envs / N_WORLDS
        self.trips.append(rewards.mean() * self.episode * robots)
        self.robot_steps.append(self.num_timesteps * PERIOD)


curve = Curve()
model = PPO("MlpPolicy", env, n_steps=128, batch_size=BATCH, seed=1, device="cpu")
model.learn(ROBOT_STEPS // PERIOD, callback=curve)
Path(FOLDER).mkdir(parents=True, exist_ok=True)
file = Path(FOLDER) / "motion.zip"
model.save(file)

# %% [markdown]
# ## Evaluate
#
# A saved model is a controller by name. It acts deterministically; with `chance=true` its actions
# have the noise of the training. One training is one sample, so results need several seeds of
# training ([the ladder](../ladder.md)).

# %%
scenario = find_scenario("es1", CHANGES)
means = {}
for name in ("ssgikf", f"sb3:{file}", f"sb3:{file},chance=true"):
    episodes = run_episodes(scenario, find_controller(name), TEST_SEEDS)
    means[name] = np.mean([episode.round_trips for episode in episodes])
    print(f"{name:45} {means[name]:6.1f} round trips")

# %%
figure, axes = plt.subplots(figsize=(6.0, 3.2), layout="constrained")
axes.plot(np.array(curve.robot_steps) / 1e6, curve.trips, label="PPO, with its noise")
axes.axhline(means["ssgikf"], linestyle="--", color="0.4", label="ssgikf, hand-written")
axes.set(xlabel="million robot-steps", ylabel="round trips of an episode")
_ = axes.legend()

# %% [markdown]
# ```sh
# swarm-forage evaluate es1 nc ssgikf sb3:runs/tutorials/motion.zip
# swarm-forage watch es1 sb3:runs/tutorials/motion.zip --html motion.html
# ```
#
# Next: [learn a weighting](learn_a_weighting.md).
