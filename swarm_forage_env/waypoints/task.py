"""The task of visiting waypoints, as the rest of the house knows it."""

from swarm_forage_env.task import TASKS, Task
from swarm_forage_env.waypoints.control import decide
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.views import exchange_of, situation_of
from swarm_forage_env.waypoints.world import PHYSICS, WaypointsWorld

WAYPOINTS = Task(
    name="waypoints",
    scenario=WaypointsScenario,
    world=WaypointsWorld,
    decide=decide,
    physics=PHYSICS,
    controller="boids-adaptive",
    agent="create",
    commanded="acceleration",
    exchange=exchange_of,
    situation=situation_of,
)

TASKS.register(WAYPOINTS.name)(WAYPOINTS)
