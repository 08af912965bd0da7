"""The task of foraging, as the rest of the house knows it."""

from swarm_forage_env.foraging.control import decide
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.views import exchange_of, situation_of
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.task import TASKS, Task

FORAGING = Task(
    name="foraging",
    scenario=Scenario,
    world=ForagingWorld,
    decide=decide,
    physics="rigid",
    controller="ssgikf",
    agent="epuck",
    commanded="wheels",
    exchange=exchange_of,
    situation=situation_of,
)

TASKS.register(FORAGING.name)(FORAGING)
