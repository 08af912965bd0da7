"""The potential of the foraging task, for potential-based shaping."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.foraging.areas import KINDS
from swarm_forage_env.foraging.metrics import nearest_areas
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.world import ForagingWorld

LEGS = 3
"""To the first nest, to the prey, back to the nest."""


def most_shaping(scenario: Scenario) -> tuple[float, str]:
    """The largest weight w of the potential in a scenario, and why.

    The potential falls from 1 to 1/3 where a trip ends and the next begins, so that a trip worth v
    pays v - 2 w / 3 in that tick; of all trips the one worth least must not pay less than nothing.
    """
    worths = [[each.worth for each in scenario.task.areas if each.kind == kind] for kind in KINDS]
    least = math.prod(min(each, default=1.0) for each in worths)
    why = f"a completed trip pays {least:g} - 2 w / 3 in its tick, which would be below zero"
    return least * LEGS / (LEGS - 1), why


class ForagingPotential:
    """How far each robot is on its round trip: a function of the true state, in [0, 1].

        Phi = (leg + 1 - d / far) / 3

    leg counts nest (first visit), prey, nest; d is the true distance to the centre of the nearest
    area of the kind that leg leads to [m], far the largest distance possible in the arena [m]: both
    as they are in the robot's own world.

    Not in the paper: the potential itself; and an episode that is cut short keeps the potential of
    its last state, as its value is bootstrapped.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """

    def __init__(self, world: ForagingWorld) -> None:
        """The potential of the robots of these worlds."""
        self._world = world

    def __call__(self) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        robots, worlds = self._world.robots, self._world.worlds
        pose, leg = robots["pose"], robots["leg"]
        x, y = 0.5 * worlds["arena"].T
        away = np.abs(worlds["areas"]).max(axis=1).T
        far = np.hypot(x + away[0], y + away[1])[:, None]
        here = np.repeat(pose[..., None, :2], 2, axis=2).reshape(-1, 2, 2)
        areas = nearest_areas(worlds, here).reshape(*leg.shape, 2, 2)
        goal = np.where((leg % 2 == 0)[..., None], areas[:, :, 0], areas[:, :, 1])
        d = np.hypot(goal[..., 0] - pose[..., 0], goal[..., 1] - pose[..., 1])
        return np.asarray((leg + 1.0 - np.minimum(d / far, 1.0)) / LEGS).reshape(-1)
