"""The potential of the waypoints task, for potential-based shaping."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.waypoints.world import WaypointsWorld


class WaypointsPotential:
    """How far each robot has come: goals reached, and the way to the next.

        Phi = goals + 1 - d / far

    d is the true distance to the goal [m], `far` the diagonal of the square of goals in the
    robot's own world.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """

    def __init__(self, world: WaypointsWorld) -> None:
        """The potential of the robots of these worlds."""
        self._world = world

    def __call__(self) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        state, side = self._world.state, 2.0 * self._world.worlds["half_side"]
        far = np.repeat(np.hypot(side, side), self._world.n_robots)
        d = np.hypot(*(state.goal - state.pose[:, :2]).T)
        return np.asarray(state.right + 1.0 - d / far)
