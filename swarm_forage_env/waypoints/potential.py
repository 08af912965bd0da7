"""The potential of the waypoints task, for potential-based shaping."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.waypoints.records import RobotState, WorldState


@kernel
def potential(robot: RobotState, world: WorldState) -> float:
    """How far a robot has come: goals reached, and the way to the next.

        Phi = goals + 1 - d / far

    d is the true distance to the goal [m], `far` the diagonal of the square of goals in the
    robot's own world.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """
    d = hypot(robot.goal[0] - robot.pose[0], robot.goal[1] - robot.pose[1])
    return float(robot.right + 1.0 - d / hypot(2.0 * world.half_side, 2.0 * world.half_side))
