"""Behaviour cloning: supervised warm start of a motion network from a hand-written motion.

Subsumption has memory (the course of its random walk, a course held past an obstacle) and draws
random numbers; the network does neither. The clone therefore learns the mean behaviour of a robot
without a goal, which is nearly straight on: the random walk is lost. So is the side on which a
robot passes an obstacle, where it chose that side in an earlier tick.
"""

from collections.abc import Sequence

import numpy as np
import torch

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import FieldCopies, FieldLayout
from swarm_forage_env.record import copied_rows
from training.actor_critic import MotionActor

SAMPLE_EVERY = 20
"""Ticks between two samples of a world; samples of successive ticks are highly correlated."""

EPOCHS, BATCH_SIZE, LEARNING_RATE = 20, 512, 1e-3

Demonstrations = tuple[Float32[Array, "samples numbers"], Float32[Array, "samples 2"]]


def clone_behaviour(actor: MotionActor, pairs: Sequence[Demonstrations]) -> float:
    """Fit a motion network to demonstrations; return its mean squared error in the last epoch.

    Batches are drawn from torch's global generator: seed it for a repeatable fit.
    """
    device = next(actor.parameters()).device
    observed = torch.from_numpy(np.concatenate([each[0] for each in pairs])).to(device)
    wheels = torch.from_numpy(np.concatenate([each[1] for each in pairs])).to(device)
    optimiser = torch.optim.Adam(actor.parameters(), LEARNING_RATE)
    for _ in range(EPOCHS):
        total = 0.0
        for rows in torch.split(torch.randperm(len(observed)), BATCH_SIZE):
            given, _ = actor(observed[rows])
            loss = torch.mean((given - wheels[rows]) ** 2)
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            total += loss.item() * len(rows)
    return total / len(observed)


def record_demonstrations(loop: Loop, layout: FieldLayout) -> Demonstrations:
    """Record observations and wheel speeds over a whole episode of a hand-written controller."""
    shown, world = FieldCopies(layout), loop.world
    observed, wheels = [], []
    for tick in range(loop.world.scenario.n_ticks):
        if tick % SAMPLE_EVERY == 0:
            seen = np.empty((*world.robots.shape, len(layout)), np.float32)
            shown.read(world, loop.controller.minds, seen)
            observed.append(seen.reshape(-1, len(layout)))
        loop.step()
        if tick % SAMPLE_EVERY == 0:  # what was commanded is shown as the last wheels
            wheels.append(copied_rows(world.robots, ("command", "wheels")))
    return np.concatenate(observed), np.concatenate(wheels)
