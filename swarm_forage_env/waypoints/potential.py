"""The potential of the waypoints task, for potential-based shaping."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.waypoints.world import WaypointsWorld


class WaypointsPotential:
    """How far each robot has come: goals reached, and the way to the next.

        Phi = goals + 1 - d / far

    d is the true distance to the goal [m], `far` the diagonal of the square of goals.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """

    def __init__(self, world: WaypointsWorld) -> None:
        """The potential of the robots of these worlds."""
        self._world = world
        side = world.scenario.task.side
        self._far = math.hypot(side, side)

    def __call__(self) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        state = self._world.state
        d = np.hypot(*(state.goal - state.pose[:, :2]).T)
        return np.asarray(state.right + 1.0 - d / self._far)
