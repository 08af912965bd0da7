# %% [markdown]
# # Learn a weighting
#
# The hand-written motion drives the robots, and a policy decides how far a robot believes what it
# receives. Exchanges are rare (0.35 % of the ticks of `es1`), so that a step of this environment
# ends with an exchange: `step_on="exchange"`. It takes some minutes and needs
# `pip install '.[train]'`.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import torch
from stable_baselines3 import PPO

from baselines.evaluation.episode import run_episodes
from baselines.evaluation.statistics import mean_interval
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

# %% tags=["parameters"]
EXCHANGES = 3_000  # of each robot
N_WORLDS = 8
ROLLOUT, BATCH = 256, 2560
TEST_SEEDS = range(1000, 1010)
CHANGES = {}  # of the scenario of the test
FOLDER = "runs/tutorials"

# %% [markdown]
# ## The environment
#
# The observation is one finished exchange: the own and the received path, which areas are known,
# and how far the estimates disagree. The action is g for nest and prey: -1 keeps the own estimate,
# 1 takes the received one.

# %%
DISCOUNT = 0.99
torch.set_num_threads(1)
env = SwarmVecEnv(
    "es1",
    n_worlds=N_WORLDS,
    learn="weighting",
    step_on="exchange",
    shaping=1.0,
    discount=DISCOUNT,
    physics="kinematic",
    stagger=True,
)
print(env.num_envs, "rows,", env.observation_space.shape, env.action_space.shape)

# %%
model = PPO(
    "MlpPolicy",
    env,
    gamma=DISCOUNT,
    n_steps=ROLLOUT,
    batch_size=BATCH,
    policy_kwargs={"log_std_init": -0.7},
    seed=1,
    device="cpu",
)
model.learn(EXCHANGES * env.num_envs)
Path(FOLDER).mkdir(parents=True, exist_ok=True)
file = Path(FOLDER) / "weighting.zip"
model.save(file)

# %% [markdown]
# ## Evaluate against the right references
#
# To beat the hand-written rule is not enough: a constant weight of one half, from which the
# training starts, beats it too. Both are therefore compared with the policy.


# %%
def half(observed):
    """A weight of one half in every exchange: 0 on the scale from -1 to 1."""
    return np.zeros((len(observed), 2), np.float32)


scenario = find_scenario("es1", CHANGES)
controllers = {
    "ssgikf": find_controller("ssgikf"),
    "one half": policy_controller(half, learn="weighting", decision_period=1),
    "learned": find_controller(f"sb3:{file}"),
    "learned-weighting, bundled": find_controller("learned-weighting"),
}
trips = {}
for name, controller in controllers.items():
    episodes = run_episodes(scenario, controller, TEST_SEEDS)
    trips[name] = [episode.round_trips for episode in episodes]
    print(f"{name:27} {mean_interval(trips[name]).value:6.1f} round trips")

# %%
figure, axes = plt.subplots(figsize=(6.0, 2.8), layout="constrained")
axes.boxplot(list(trips.values()), orientation="horizontal", tick_labels=list(trips))
_ = axes.set_xlabel("round trips in half an hour")

# %% [markdown]
# Under the hand-written motion the weight of a single exchange leaves little to gain. The bundled
# `learned-weighting` was trained on the true errors and runs over more frequent exchanges
# ([learned layers](../learning.md)).
