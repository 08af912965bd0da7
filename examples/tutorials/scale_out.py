# %% [markdown]
# # Scale out
#
# Three ways to more robot-steps per second: many worlds in one block, then threads, then processes.
# Rates depend on the machine; [performance](../performance.md) lists what was measured on which. It
# takes a minute and needs `pip install '.[evaluate]'`, for the figure alone.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np

from swarm_forage_env import ArrayEnv

# %% tags=["parameters"]
STEPS = 200
BLOCKS = (1, 8, 64, 256)  # worlds
THREADED = 512  # worlds of the comparison of threads


# %%
def rate(**keywords):
    """Million robot-steps per second of the batch API."""
    env = ArrayEnv("es1", learn="motion", physics="kinematic", **keywords)
    observations, _ = env.reset(seed=0)
    actions = np.zeros((*observations.shape[:2], 2), np.float32)
    env.step(actions)  # compiles
    start = time.perf_counter()
    for _ in range(STEPS):
        env.step(actions)
    ticks = STEPS * 10  # an action is held for ten ticks
    return actions.shape[0] * actions.shape[1] * ticks / (time.perf_counter() - start) / 1e6


# %% [markdown]
# ## Worlds in a block
#
# A step has a fixed cost in Python. A block pays it once for all its worlds. A world in a block is
# equal to the same world alone, bit for bit.

# %%
rates = {n_worlds: rate(n_worlds=n_worlds) for n_worlds in BLOCKS}
for n_worlds, found in rates.items():
    print(f"{n_worlds:4} worlds: {found:.2f} million robot-steps a second")

# %%
figure, axes = plt.subplots(figsize=(5.5, 2.8), layout="constrained")
axes.semilogx(list(rates), list(rates.values()), "o-")
_ = axes.set(xlabel="worlds in a block", ylabel="million robot-steps\na second", ylim=(0, None))

# %% [markdown]
# ## Threads
#
# `threads=2` splits a block into chunks. The result does not depend on the number of threads. They
# pay from ten worlds on.

# %%
for threads in (1, 2):
    found = rate(n_worlds=THREADED, threads=threads)
    print(f"{threads} threads, {THREADED} worlds: {found:.2f} million robot-steps a second")

# %% [markdown]
# ## Processes
#
# Evaluation and training run in several processes: `swarm-forage evaluate es1 ssgikf --workers 8`,
# `swarm-forage benchmark ladder --workers 8`. Each process runs its own blocks, and the results are
# the same as with one. With `--backend ray` they are processes of a [cluster](../cluster.md).
# RLlib's env runners hold a block each ([example](../../examples/rllib_ppo.py)).
#
# Next: [a thousand worlds on a GPU](a_thousand_worlds_on_a_gpu.md).
