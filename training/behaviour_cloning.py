"""Warm start: a network copies what a motion does, before it learns to do better.

Subsumption remembers (the course of its random walk, a course held past an obstacle) and
draws; the network does neither. What a robot does without a goal is therefore copied in the
mean, nearly straight on, and the random walk is lost; so is the choice of a side to pass on,
where it was made earlier than in this tick.
"""

from collections.abc import Sequence

import numpy as np
import torch

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.layout import ObservationLayout, Sheet
from swarm_forage_env.loop import ControlLoop
from training.actor_critic import MotionActor

SAMPLE_EVERY = 20
"""Ticks between two samples of a world: successive ones are alike."""

EPOCHS, BATCH_SIZE, LEARNING_RATE = 20, 512, 1e-3

Demonstrations = tuple[Float32[Array, "samples numbers"], Float32[Array, "samples 2"]]


def clone_behaviour(actor: MotionActor, pairs: Sequence[Demonstrations]) -> float:
    """Fit a network to situations and wheels; its mean squared error over the last epoch.

    Draws from torch's generator: seed it for a repeatable fit.
    """
    observed = torch.from_numpy(np.concatenate([each[0] for each in pairs]))
    wheels = torch.from_numpy(np.concatenate([each[1] for each in pairs]))
    optimiser = torch.optim.Adam(actor.parameters(), LEARNING_RATE)
    total = 0.0
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


def record_demonstrations(loop: ControlLoop, layout: ObservationLayout) -> Demonstrations:
    """Observations and wheels of a whole episode of a hand-written controller."""
    sheet, estimator = Sheet(layout, loop.world.rows), loop.controller.estimator
    observed, wheels = [], []
    for tick in range(loop.world.scenario.n_ticks):
        if tick % SAMPLE_EVERY == 0:
            parts = {"encounter": estimator.encounter, "situation": estimator.situation}
            observed.append(sheet.write(parts))
        loop.step()
        if tick % SAMPLE_EVERY == 0:  # what was commanded is shown as the last wheels
            wheels.append(estimator.situation.wheels)
    return np.concatenate(observed), np.concatenate(wheels)
