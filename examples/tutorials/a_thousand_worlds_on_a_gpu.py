# %% [markdown]
# # A thousand worlds on a GPU
#
# Worlds, policy and learner on one NVIDIA GPU: no observation and no action crosses to the CPU. On
# a GPU it needs `pip install '.[cuda,train]'` and torch in its build for CUDA. The same code runs
# on a CPU with fewer worlds.
#
# **The outputs of the cells are of a CPU** (`DEVICE = "cpu"`). The figures of a GPU at the end were
# measured on 26 November 2026 on one NVIDIA H200.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np
import torch

from swarm_forage_env import array_env
from training.actor_critic import ActorCritic
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv

# %% tags=["parameters"]
DEVICE = "cpu"  # "cuda" on a GPU
N_WORLDS = 8  # 1024 on a GPU
ROBOT_STEPS = 6_000_000  # 1_000_000_000 on a GPU
BLOCKS = (1, 10, 100)  # worlds; up to 20_000 on a GPU

# %% [markdown]
# ## Worlds
#
# `array_env(device="cuda")` keeps all records in the memory of the GPU. Its arrays become tensors
# without a copy. A GPU runs the engine `kinematic` only.


# %%
def rate(n_worlds, steps=20):
    """Million robot-steps per second; an action is held for ten ticks."""
    env = array_env("es1", device=DEVICE, n_worlds=n_worlds, physics="kinematic")
    env.reset(seed=0)
    actions = torch.zeros((n_worlds, len(env.learners), 2), device=DEVICE)
    given = actions.numpy() if DEVICE == "cpu" else actions
    env.step(given)  # compiles
    start = time.perf_counter()
    for _ in range(steps):
        env.step(given)
    if DEVICE == "cuda":
        torch.cuda.synchronize()
    return n_worlds * len(env.learners) * steps * 10 / (time.perf_counter() - start) / 1e6


rates = {n_worlds: rate(n_worlds) for n_worlds in BLOCKS}
for n_worlds, found in rates.items():
    print(f"{n_worlds:5} worlds: {found:6.2f} million robot-steps a second")

# %% [markdown]
# ## Learn
#
# `TensorVecEnv` gives the learners of all worlds as rows of tensors, and `PPOLearner` trains its
# `ActorCritic` on them. The mean reward of a rollout, times robots and decisions, is the number of
# round trips that an episode would have.

# %%
torch.set_num_threads(1)
worlds = array_env("es1", device=DEVICE, n_worlds=N_WORLDS, physics="kinematic", stagger=True)
tensors = TensorVecEnv([worlds])
torch.manual_seed(1)
policy = ActorCritic(len(tensors.observation_layout), n_actions=2)
learner = PPOLearner(tensors, policy, PPOHyperparameters())
robot_steps, trips = [], []
start = time.perf_counter()
while learner.robot_steps < ROBOT_STEPS:
    learner.learn(robot_steps=1, seed=None if robot_steps else 1)  # one rollout and its update
    robot_steps.append(learner.robot_steps)
    rate_of_trips = learner.diagnostics["train/reward"] * worlds.max_cycles
    trips.append(rate_of_trips * len(worlds.learners))
seconds = time.perf_counter() - start
print(f"{learner.robot_steps / 1e6:.1f} million robot-steps in {seconds:.0f} s,", end=" ")
print(f"{trips[-1]:.0f} round trips an episode, with the noise of the training")

# %%
figure, axes = plt.subplots(figsize=(6.0, 3.0), layout="constrained")
axes.plot(np.array(robot_steps) / 1e6, trips)
_ = axes.set(xlabel="million robot-steps", ylabel="round trips of an episode", title="this CPU")

# %% [markdown]
# ## What a GPU does
#
# Kept figures, measured on 26 November 2026 on one NVIDIA H200
# ([performance](../performance.md#on-a-gpu), [train on a
# GPU](../guides/gpu.md#how-long-it-takes)): worlds alone under `ssgikf`, and the best of
# some trainings, of 2048 worlds for 6 s.

# %%
H200_WORLDS = {100: 25, 1_000: 163, 2_048: 284, 10_000: 362}
H200_TRAINING = {4.5: 257, 6: 266}

figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.0), layout="constrained")
left.loglog(list(H200_WORLDS), list(H200_WORLDS.values()), "s-", label="H200, kept")
left.loglog(list(rates), list(rates.values()), "o-", label="this CPU")
left.set(xlabel="worlds", ylabel="million robot-steps a second")
left.legend()
right.plot(list(H200_TRAINING), list(H200_TRAINING.values()), "s-", label="H200, kept")
right.axhline(163, linestyle="--", color="0.4", label="ssgikf")
right.set(xlabel="seconds of training", ylabel="round trips")
_ = right.legend()

# %% [markdown]
# A few worlds leave a GPU idle; thousands use it. The command for all of this is
# `swarm-forage train motion es1 --device cuda --physics kinematic`. What runs
# on a GPU, and when one pays: [train on a GPU](../guides/gpu.md).
