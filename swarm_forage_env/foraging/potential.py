"""The potential of the foraging task, for potential-based shaping."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.foraging.world import ForagingWorld

LEGS = 3
"""To the first nest, to the prey, back to the nest."""

MOST_SHAPING = 1.5, "a completed trip pays 1 - 2 w / 3 in its tick, which would be below zero"
"""The largest weight w of the potential: it falls from 1 to 1/3 where the next trip begins."""


class ForagingPotential:
    """How far each robot is on its round trip: a function of the true state, in [0, 1].

        Phi = (leg + 1 - d / far) / 3

    leg counts nest (first visit), prey, nest; d is the true distance to the centre of the area
    that leg leads to [m], far the largest distance possible in the arena [m].

    Not in the paper: the potential itself; and an episode that is cut short keeps the potential of
    its last state, as its value is bootstrapped.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """

    def __init__(self, world: ForagingWorld) -> None:
        """The potential of the robots of these worlds."""
        self._world = world
        self._areas = world.areas
        arena = world.scenario.arena
        x, y = 0.5 * arena.length, 0.5 * arena.width
        self._far = float(np.hypot(x + self._areas[1, 0], y))

    def __call__(self) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        state = self._world.state
        way = self._areas[state.leg % 2] - state.pose[:, :2]  # legs lead to areas 0, 1, 0
        d = np.hypot(way[:, 0], way[:, 1])
        return np.asarray((state.leg + 1.0 - np.minimum(d / self._far, 1.0)) / LEGS)
