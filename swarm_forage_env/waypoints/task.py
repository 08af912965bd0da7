"""The task of visiting waypoints, as the rest of the code knows it."""

from swarm_forage_env.no_layers import NoLayers
from swarm_forage_env.task import TASKS, Task
from swarm_forage_env.waypoints.control import decide_world
from swarm_forage_env.waypoints.drawing import scene_of, stage_of
from swarm_forage_env.waypoints.episode import WAYPOINT_EPISODE
from swarm_forage_env.waypoints.events import Events, write_events
from swarm_forage_env.waypoints.global_state import WaypointsState
from swarm_forage_env.waypoints.policies import LEARNABLE, STEERINGS, carry_out, hear_words, robots
from swarm_forage_env.waypoints.potential import potential
from swarm_forage_env.waypoints.records import Said
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.trajectory import WAYPOINT_TRAJECTORY
from swarm_forage_env.waypoints.world import PHYSICS, WaypointsWorld

WAYPOINTS = Task(
    name="waypoints",
    scenario=WaypointsScenario,
    world=WaypointsWorld,
    decide=decide_world,
    physics=PHYSICS,
    controller="boids-adaptive",
    agent="create",
    commanded="acceleration",
    steered_by=("robots.readings",),
    policies=LEARNABLE,
    steerings=STEERINGS,
    is_joint=True,
    no_layers=NoLayers(Said, carry_out, hear_words, robots),
    potential=potential,
    global_state=WaypointsState,
    episode=WAYPOINT_EPISODE,
    events=Events,
    write_events=write_events,
    stage=stage_of,
    scene=scene_of,
    trajectory=WAYPOINT_TRAJECTORY,
)

TASKS.register(WAYPOINTS.name)(WAYPOINTS)
