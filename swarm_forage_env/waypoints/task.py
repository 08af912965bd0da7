"""The task of visiting waypoints, as the rest of the code knows it."""

from swarm_forage_env.no_layers import NoLayers
from swarm_forage_env.task import TASKS, Task
from swarm_forage_env.waypoints.control import decide_world
from swarm_forage_env.waypoints.drawing import scene_of, stage_of
from swarm_forage_env.waypoints.episode import WAYPOINT_EPISODE
from swarm_forage_env.waypoints.global_state import WAYPOINT_TRAJECTORY, WaypointsState
from swarm_forage_env.waypoints.policies import LEARNABLE, STEERINGS, carry_out, hear_words, robots
from swarm_forage_env.waypoints.records import Said
from swarm_forage_env.waypoints.rewards import WAYPOINTS_POTENTIAL, WaypointEvents
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.world import WaypointsWorld

WAYPOINTS = Task(
    name="waypoints",
    scenario=WaypointsScenario,
    world=WaypointsWorld,
    decide=decide_world,
    controller="boids-adaptive",
    agent="create",
    policies=LEARNABLE,
    steerings=STEERINGS,
    is_joint=True,
    no_layers=NoLayers(Said, carry_out, hear_words, robots),
    potential=WAYPOINTS_POTENTIAL,
    global_state=WaypointsState,
    episode=WAYPOINT_EPISODE,
    events=WaypointEvents,
    drawing=(stage_of, scene_of),
    trajectory=WAYPOINT_TRAJECTORY,
)

TASKS.register(WAYPOINTS.name)(WAYPOINTS)
