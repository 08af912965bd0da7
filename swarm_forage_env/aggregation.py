"""Aggregation: e-pucks gather on one of two black spots, which they cannot tell apart.

Francesca et al. 2014, AutoMoDe: a novel approach to the automatic design of control software for
robot swarms (Swarm Intelligence 8), for the task; arena and spots are those of AutoMoDe's loop
function AggregationTwoSpots. Not in the paper, and chosen here: the reward of each tick.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from swarm_forage_env.arrays import Array, Float64, Int8
from swarm_forage_env.compiler import kernel
from swarm_forage_env.episode import Episode, EpisodeKind, judged_at_the_end
from swarm_forage_env.epuck.obstacles import regular_polygon
from swarm_forage_env.epuck.parts import Arena, Mission
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.epuck.task import EpuckTask
from swarm_forage_env.epuck.world import EpuckWorld
from swarm_forage_env.parameters import Positive
from swarm_forage_env.record import field
from swarm_forage_env.registry import ORIGINS, SCENARIOS

NO_SPOT = -1


class AggregationMission(Mission):
    """Two black spots on a white floor, to the left and right of the centre."""

    spot_distance: Positive = Field(1.0, description="Distance of the centres [m] (published)")
    spot_radius: Positive = Field(0.3, description="Radius of each spot [m] (published)")


class AggregationScenario(EpuckScenario):
    """All parameters of an aggregation world."""

    task: AggregationMission = AggregationMission()

    if TYPE_CHECKING:
        _episode: type["AggregationEpisode"]

    @property
    def areas(self) -> Float64[Array, "areas 2"]:
        """Centres of the spots, world frame [m]."""
        return 0.5 * self.task.spot_distance * np.array([[-1.0, 0.0], [1.0, 0.0]])

    @property
    def area_radius(self) -> float:
        """Radius of a spot [m]."""
        return self.task.spot_radius


class AggregationWorldState(EpuckWorldState):
    """State of a world with two spots."""

    spots: Float64[Array, "spots 2"] = field(np.float64, 2, 2, unit="m")
    spot_radius: float = field(np.float64, unit="m")


class AggregationState(EpuckState):
    """State of an e-puck, with the spot that it is on."""

    spot: int = field(np.int8, start=NO_SPOT)
    """Index of the spot under the robot, 0 or 1, or NO_SPOT. Writer: score."""


@kernel
def spot_at(x: float, y: float, world: AggregationWorldState) -> int:
    """Return the spot under a point of the world frame [m], or NO_SPOT."""
    for k in range(2):
        dx, dy = x - world.spots[k, 0], y - world.spots[k, 1]
        if dx * dx + dy * dy < world.spot_radius * world.spot_radius:
            return k
    return NO_SPOT


@kernel
def brightness_at(x: float, y: float, world: AggregationWorldState) -> float:
    """Return the brightness of the floor under a point: 0 on a spot, 1 elsewhere."""
    return 1.0 if spot_at(x, y, world) == NO_SPOT else 0.0


@kernel
def score(swarm: Array, i: int, world: AggregationWorldState) -> None:
    """Reward robot i with the share of the swarm that is on its spot, times the tick [s]."""
    robot, together = swarm[i], 0
    robot.spot = spot_at(robot.pose[0], robot.pose[1], world)
    if robot.spot != NO_SPOT:
        for j in range(swarm.shape[0]):
            together += spot_at(swarm[j].pose[0], swarm[j].pose[1], world) == robot.spot
    robot.reward = world.dt * together / swarm.shape[0]


class AggregationWorld(
    EpuckWorld, robot=AggregationState, world=AggregationWorldState,
    functions={"brightness_at": brightness_at, "score": score},
):  # fmt: skip
    """A block of aggregation worlds."""

    @staticmethod
    def write_task(scenario: AggregationScenario, out_worlds: Array) -> None:
        """Write the centres and the radius of the spots."""
        out_worlds["spots"], out_worlds["spot_radius"] = scenario.areas, scenario.area_radius


def gathered(spots: Int8[Array, "worlds robots"]) -> Float64[Array, " worlds"]:
    """Return the share of each swarm on the spot with more robots: max(N_a, N_b) / N.

    Source: Francesca2014, the objective function of aggregation.
    """
    return np.asarray(np.maximum(*((spots == k).mean(axis=1) for k in range(2))))


@dataclass(frozen=True, kw_only=True)
class AggregationEpisode(Episode):
    """Result of one episode: the share of the robots on the fuller spot, at the end."""

    gathered: float


AGGREGATION = EpuckTask(
    name="aggregation",
    scenario=AggregationScenario,
    world=AggregationWorld,
    controller="gather",
    episode=EpisodeKind(
        AggregationEpisode,
        judged_at_the_end(lambda world: {"gathered": gathered(world.robots["spot"])}),
        "gathered", "Share gathered", {"gathered": ("gathered\n[%]", 100.0)},
    ),
    headings=("On a spot", "On the fuller spot"),
    shown=lambda world, w: (world.robots["spot"][w] >= 0, gathered(world.robots["spot"])[w]),
).register()  # fmt: skip

SCENARIOS.register("aggregation", "robots gather on one of two black spots")(
    AggregationScenario(
        name="aggregation",
        arena=Arena(length=2.6, width=2.6, corners=regular_polygon(12, 1.275)),
        task=AggregationMission(n_robots=20, duration=250.0, start_radius=1.1),
    )
)
ORIGINS["aggregation"] = {
    **dict.fromkeys(("arena.length", "arena.width"), "Large enough for the polygon (derived)"),
    "arena.corners": "AutoMoDe, a dodecagon (published)",
    "task.n_robots": "AutoMoDe (published)", "task.duration": "For moves between spots (chosen)",
    "task.start_radius": "Covers nearly the whole arena (chosen)",
}  # fmt: skip
