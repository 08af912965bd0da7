"""Definition of the task of foraging."""

from swarm_forage_env.epuck.task import ON_GPU, slots
from swarm_forage_env.foraging import global_state, policies
from swarm_forage_env.foraging.control import decide_world
from swarm_forage_env.foraging.drawing import scene_of, stage_of
from swarm_forage_env.foraging.episode import FORAGING_EPISODE
from swarm_forage_env.foraging.records import PolicyMessages
from swarm_forage_env.foraging.rewards import FORAGING_POTENTIAL, ForagingEvents
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.raw_control import RawControl
from swarm_forage_env.task import TASKS, Task

FORAGING = Task(
    name="foraging",
    scenario=Scenario,
    world=ForagingWorld,
    decide=decide_world,
    physics="rigid",
    controller="ssgikf",
    agent="epuck",
    steered_by=("robots.readings", "robots.heard"),
    policies=policies.LEARNABLE,
    steerings=policies.FORAGING_STEERINGS,
    gpu=ON_GPU,
    raw_control=RawControl(PolicyMessages, policies.apply_action, policies.hear_words, slots),
    potential=FORAGING_POTENTIAL,
    global_state=global_state.ForagingState,
    episode=FORAGING_EPISODE,
    events=ForagingEvents,
    drawing=(stage_of, scene_of),
    trajectory=global_state.FORAGING_TRAJECTORY,
)

TASKS.register(FORAGING.name)(FORAGING)
