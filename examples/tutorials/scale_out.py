# %% [markdown]
# # Scale out
#
# How to get more robot-steps a second: many worlds in one block, then threads, then processes. It
# needs `pip install .`, the core. Rates depend on the machine; what is measured where stands in
# [performance](../performance.md).

# %%
import os
import time

import numpy as np

from swarm_forage_env import ArrayEnv

SMALL = os.environ.get("SWARM_FORAGE_TUTORIAL") == "small"
STEPS = 5 if SMALL else 200


def rate(**keywords):
    """Million robot-steps per second of the batch API."""
    env = ArrayEnv("es1", learn="motion", physics="kinematic", **keywords)
    observations, _ = env.reset(seed=0)
    actions = np.zeros((*observations.shape[:2], 2), np.float32)
    env.step(actions)
    start = time.perf_counter()
    for _ in range(STEPS):
        env.step(actions)
    ticks = STEPS * 10  # an action is held for ten ticks
    return actions.shape[0] * actions.shape[1] * ticks / (time.perf_counter() - start) / 1e6


# %% [markdown]
# ## Worlds in a block
#
# A step has a fixed cost in Python; a block pays it once for all its worlds. A world in a block
# does what it does alone, bit for bit.

# %%
for n_worlds in (1, 8) if SMALL else (1, 8, 64, 256):
    print(f"{n_worlds:4} worlds: {rate(n_worlds=n_worlds):.2f} million robot-steps a second")

# %% [markdown]
# ## Threads
#
# `threads=2` splits a block into chunks. The result does not depend on the number of threads.
# They pay under `kinematic` with hundreds of worlds, and not at all under `rigid`.

# %%
for threads in (1, 2):
    n_worlds = 16 if SMALL else 512
    found = rate(n_worlds=n_worlds, threads=threads)
    print(f"{threads} threads, {n_worlds} worlds: {found:.2f} million robot-steps a second")

# %% [markdown]
# ## Processes
#
# Evaluation and training spread over processes: `swarm-forage evaluate es1 ssgikf --workers 8`,
# `swarm-forage benchmark ladder --workers 8`. Each process runs blocks of its own, and the
# numbers are the same as with one. With `--backend ray` they are processes of a
# [cluster](../cluster.md). RLlib's env runners hold a block each
# ([example](../../examples/rllib_ppo.py)).
