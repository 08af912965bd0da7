"""A task of somebody else's in one file: e-pucks drive over as much of the floor as they can."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.controller import LayeredController
from baselines.estimators.no_estimator import NoEstimator
from baselines.motion import MOTIONS
from baselines.weighting.filter import Filter
from swarm_forage_env.compiler import kernel
from swarm_forage_env.episode import Episode, EpisodeKind, judged_at_the_end
from swarm_forage_env.epuck.parts import Mission
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.epuck.task import EpuckTask
from swarm_forage_env.epuck.world import EpuckWorld
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import Parameters, Positive
from swarm_forage_env.record import field
from swarm_forage_env.registry import CONTROLLERS, SCENARIOS

SIDE = 20
"""Cells of the floor along each side."""

NEVER = -1


class CoverageMission(Mission):
    """Nothing but robots and time."""

    duration: Positive = Field(120.0, description="Length of an episode [s] (chosen)")


class CoverageScenario(EpuckScenario):
    """Everything that fixes a world of coverage but its seed."""

    task: CoverageMission = CoverageMission()


class CoverageWorldState(EpuckWorldState):
    """A world, and which of its floor was driven over."""

    reached = field(np.int32, SIDE, SIDE, unit="ticks", start=NEVER)
    """Tick at which each cell was reached first. Writers: begin_world, score."""


@kernel
def cell_of(robot, world, axis):
    """The cell under a robot along an axis."""
    share = robot.pose[axis] / world.arena[axis] + 0.5
    return min(max(int(share * SIDE), 0), SIDE - 1)


@kernel
def begin_world(world):
    """Nobody was anywhere."""
    world.reached[:] = NEVER


@kernel
def brightness_at(x, y, world):
    """A white floor."""
    return 1.0


@kernel
def score(swarm, i, world):
    """Reward the first robot in a cell; of several in one tick, that with the lowest number."""
    swarm[i].reward = 0.0
    column, row = cell_of(swarm[i], world, 0), cell_of(swarm[i], world, 1)
    if world.reached[column, row] != NEVER and world.reached[column, row] != world.ticks:
        return
    world.reached[column, row] = world.ticks  # whoever comes in this tick writes the same
    for j in range(i):
        if cell_of(swarm[j], world, 0) == column and cell_of(swarm[j], world, 1) == row:
            return
    swarm[i].reward = 1.0


class CoverageWorld(
    EpuckWorld,
    robot=EpuckState,
    world=CoverageWorldState,
    functions={"begin_world": begin_world, "brightness_at": brightness_at, "score": score},
):
    """Worlds of coverage, side by side."""


@dataclass(frozen=True, kw_only=True)
class CoverageEpisode(Episode):
    """The result of one episode."""

    covered: float


def covered(world):
    """The share of each floor that was driven over."""
    return np.mean(world.worlds["reached"] != NEVER, axis=(1, 2))


EpuckTask(
    name="coverage",
    scenario=CoverageScenario,
    world=CoverageWorld,
    controller="sweep",
    episode=EpisodeKind(
        CoverageEpisode,
        judged_at_the_end(lambda world: {"covered": covered(world)}),
        "covered",
        "Share covered",
        {"covered": ("covered\n[%]", 100.0)},
    ),
    headings=("Messages", "Covered"),
    shown=lambda world, which: (world.robots["messages"][which], covered(world)[which]),
).register()

SCENARIOS.register("coverage", "robots drive over the floor")(CoverageScenario(name="coverage"))


@kernel
def steer(situation, readings, heard, wheels, memory, numbers):
    """Straight on, and away from what is near."""
    left, right = 0.0, 0.0
    for k in range(3):
        left, right = max(left, readings.proximity[7 - k]), max(right, readings.proximity[k])
    is_blocked = max(left, right) > numbers.near
    wheels[0] = -1.0 if is_blocked and right > left * numbers.bias else 1.0
    wheels[1] = -1.0 if is_blocked and right <= left * numbers.bias else 1.0


@MOTIONS.register("sweep")
class Sweep(Parameters):
    """Straight on, and away from what is near. Source: none needed."""

    tasks: ClassVar[tuple[str, ...]] = ("epuck",)

    near: Positive = Field(0.1, description="Infrared reading that turns a robot (chosen)")
    bias: Positive = Field(1.05, description="Which side it prefers to turn to (chosen)")

    def layer(self, scenario):
        """The function of the motion, with its numbers."""
        return MotionLayer(steer, {"near": self.near, "bias": self.bias})


SWEEP = LayeredController("sweep", NoEstimator(), Filter(), Sweep())
CONTROLLERS.register(SWEEP.name)(SWEEP)
