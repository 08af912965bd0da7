"""The task of foraging, as the rest of the code knows it."""

from swarm_forage_env.epuck.policies import slots
from swarm_forage_env.epuck.task import ON_GPU
from swarm_forage_env.foraging.control import decide_world
from swarm_forage_env.foraging.drawing import scene_of, stage_of
from swarm_forage_env.foraging.episode import FORAGING_EPISODE
from swarm_forage_env.foraging.global_state import (
    FORAGING_TRAJECTORY,
    ForagingState,
    log_beliefs,
    log_counts,
)
from swarm_forage_env.foraging.policies import (
    FORAGING_STEERINGS,
    LEARNABLE,
    apply_action,
    hear_words,
)
from swarm_forage_env.foraging.records import Said
from swarm_forage_env.foraging.rewards import FORAGING_POTENTIAL, ForagingEvents
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.interface import GpuTask
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
    policies=LEARNABLE,
    steerings=FORAGING_STEERINGS,
    gpu=GpuTask(functions=ON_GPU, log={True: log_beliefs, False: log_counts}),
    raw_control=RawControl(Said, apply_action, hear_words, slots),
    potential=FORAGING_POTENTIAL,
    global_state=ForagingState,
    episode=FORAGING_EPISODE,
    events=ForagingEvents,
    drawing=(stage_of, scene_of),
    trajectory=FORAGING_TRAJECTORY,
)

TASKS.register(FORAGING.name)(FORAGING)
