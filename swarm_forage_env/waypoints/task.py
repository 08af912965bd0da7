"""The waypoints task: its events, its potential and its entry in the registry."""

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.raw_control import RawControl
from swarm_forage_env.record import field
from swarm_forage_env.task import TASKS, Events, Potential, Task
from swarm_forage_env.waypoints import policies
from swarm_forage_env.waypoints.control import decide_world
from swarm_forage_env.waypoints.drawing import scene_of, stage_of
from swarm_forage_env.waypoints.episode import WAYPOINT_EPISODE
from swarm_forage_env.waypoints.global_state import WAYPOINT_TRAJECTORY, WaypointsState
from swarm_forage_env.waypoints.records import PolicyMessages, RobotState, WorldState
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.world import WaypointsWorld


class WaypointEvents(Events):
    """Events of one robot in the last tick."""

    trip: bool = field(np.bool_)
    """Whether it claimed its goal and was there."""
    loss: bool = field(np.bool_)
    """Whether it claimed its goal and was not there."""
    message: int = field(np.int32)
    """Number of robots that it sees, and thus hears."""

    @staticmethod
    def write(world: WaypointsWorld, before: Array, out: Array) -> None:
        """Write the events of the robots since their states in `before`."""
        out["trip"] = world.robots["right"] > before["right"]
        out["loss"] = world.robots["wrong"] > before["wrong"]
        out["message"] = np.count_nonzero(world.sightings["seen"], axis=2)


@kernel
def potential(robot: RobotState, world: WorldState) -> float:
    """Return the progress of a robot: goals reached, plus progress towards the next.

        Phi = goals + 1 - d / far

    d is the true distance to the goal [m], `far` the diagonal of the square of goals in the world
    of the robot.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """
    d = hypot(robot.goal[0] - robot.pose[0], robot.goal[1] - robot.pose[1])
    return float(robot.right + 1.0 - d / hypot(2.0 * world.half_side, 2.0 * world.half_side))


WAYPOINTS = Task(
    name="waypoints",
    scenario=WaypointsScenario,
    world=WaypointsWorld,
    decide=decide_world,
    controller="boids-adaptive",
    agent="create",
    policies=policies.LEARNABLE,
    steerings=policies.STEERINGS,
    is_joint=True,
    raw_control=RawControl(
        PolicyMessages, policies.apply_action, policies.hear_words, policies.robots
    ),
    potential=Potential(potential),
    global_state=WaypointsState,
    episode=WAYPOINT_EPISODE,
    events=WaypointEvents,
    drawing=(stage_of, scene_of),
    trajectory=WAYPOINT_TRAJECTORY,
)

TASKS.register(WAYPOINTS.name)(WAYPOINTS)
