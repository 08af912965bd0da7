"""The potential of the foraging task, for potential-based shaping."""

import math

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Float64
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.foraging.areas import KINDS
from swarm_forage_env.foraging.floor import distance_to_kind
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.task import Potential

LEGS = 3
"""To the first nest, to the prey, back to the nest."""


@kernel
def farthest(world: WorldState) -> float:
    """The largest distance that a robot can have from the centre of an area [m]."""
    x, y = 0.0, 0.0
    for k in range(world.areas.shape[0]):
        x, y = max(x, abs(world.areas[k, 0])), max(y, abs(world.areas[k, 1]))
    return float(hypot(0.5 * world.arena[0] + x, 0.5 * world.arena[1] + y))


@kernel
def potential(robot: RobotState, world: WorldState) -> float:
    """How far a robot is on its round trip: a function of the true state, in [0, 1].

        Phi = (leg + 1 - d / far) / 3

    leg counts nest (first visit), prey, nest; d is the true distance to the centre of the nearest
    area of the kind that leg leads to [m], far the largest distance possible in the arena [m]: both
    as they are in the robot's own world.

    Not in the paper: the potential itself; and an episode that is cut short keeps the potential of
    its last state, as its value is bootstrapped.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """
    kind = NEST if robot.leg % 2 == 0 else PREY
    d = distance_to_kind(robot.pose[0], robot.pose[1], kind, world)
    return float((robot.leg + 1.0 - min(d / farthest(world), 1.0)) / LEGS)


@entry_point
def write_potentials(robots: Array, worlds: Array, out: Float64[Array, "worlds robots"]) -> None:
    """Write the potential of every robot."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[w, i] = potential(robots[w, i], worlds[w])


class ForagingPotential(Potential):
    """The potential of every robot of a block of worlds, as `potential` defines it."""

    def __call__(self) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        out = np.empty(self._world.robots.shape)
        write_potentials(self._world.robots, self._world.worlds, out)
        return out.reshape(-1)

    @classmethod
    def max_shaping(cls, scenario: Scenario) -> tuple[float, str]:
        """The largest weight w of the potential in a scenario, and why.

        The potential falls from 1 to 1/3 where a trip ends and the next begins, so that a trip
        worth v pays v - 2 w / 3 in that tick; the trip worth least must not pay less than nothing.
        """
        areas = scenario.task.areas
        worths = [[each.worth for each in areas if each.kind == kind] for kind in KINDS]
        least = math.prod(min(each, default=1.0) for each in worths)
        why = f"a completed trip pays {least:g} - 2 w / 3 in its tick, which would be below zero"
        return least * LEGS / (LEGS - 1), why
