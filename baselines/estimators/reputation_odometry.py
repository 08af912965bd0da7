"""Reputation odometry: sceptical odometry of robots that remember who told what, and how it was.

Gutierrez et al. 2009 (TR), Sections 4 and 5, for social odometry. VanCalck2023, for the second
witness. JosangIsmail2002, The beta reputation system, for the reputations.

Not in the papers, and chosen here:
- the weighting may be asked about areas that the robot does not know, too (`weighs_unknown`): what
  was told is copied if its weight is at least one half, and else remembered only;
- all that `sceptical_odometry` and `reputation` chose.
"""

from pydantic import Field

from baselines.estimators.area_memory import choose_goal, dead_reckon, find_areas, notice_loss
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import NOBODY, NOWHERE
from baselines.estimators.message_exchange import is_merged, merge_area
from baselines.estimators.reputation import (
    ReputationMind,
    describe_teller,
    judge_by_area,
    judge_by_loss,
    remember,
)
from baselines.estimators.sceptical_odometry import KERNELS as SCEPTICAL_KERNELS
from baselines.estimators.sceptical_odometry import (
    ScepticalOdometryParameters,
    is_confirmed,
    listen,
)
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.differential_drive import path_length
from swarm_forage_env.foraging.control import observe_world
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.parameters import NotNegative
from swarm_forage_env.record import Numbers

COPIED_FROM = 0.5
"""Weight from which on the place of an area that the robot does not know is copied."""


@kernel
def take_in(mind: ReputationMind, shared: Array, readings: Readings, numbers: Numbers) -> None:
    """As social odometry; and judge by what the robot found or did not find."""
    belief, odometry = mind.belief, readings.odometry
    before, goal = belief.on_area, belief.goal
    mind.reputation.path += path_length(float(odometry[0]), float(odometry[1]), numbers.axle)
    dead_reckon(belief, odometry, numbers.axle)
    find_areas(belief, readings.ground, numbers.to_centre)
    notice_loss(belief, odometry, numbers)
    if belief.on_area != NOWHERE and belief.on_area != before:
        judge_by_area(mind.reputation, belief, belief.on_area, numbers)
    if belief.is_lost:
        judge_by_loss(mind.reputation, belief, goal, numbers)
    choose_goal(belief)


@kernel
def listen_and_remember(crowd: Array, i: int, heard: Heard, numbers: Numbers) -> bool:
    """Start, go on with or end the exchange of robot i; of one that ended see who told what."""
    has_ended = listen(crowd, i, heard, numbers)
    if has_ended:
        describe_teller(crowd[i], numbers)
        for area in range(2):
            if crowd[i].belief.heard_weight[area] > 0.0:
                remember(crowd[i], area, numbers)
    return has_ended


@kernel
def is_asked(exchange: Exchange, area: int, numbers: Numbers) -> bool:
    """The weighting is asked about the area: both robots know it, or the partner alone does."""
    if exchange.own_known[area]:
        return bool(exchange.heard_known[area])
    return bool(exchange.heard_known[area]) and numbers.weighs_unknown > 0.0


@kernel
def is_copied(mind: ReputationMind, area: int, numbers: Numbers) -> bool:
    """What was told of an area that the robot does not know is taken over."""
    if numbers.weighs_unknown > 0.0:
        return bool(mind.exchange.weight[area] >= COPIED_FROM)
    return is_confirmed(mind.belief, area, numbers.agreement)


@kernel
def merge(mind: ReputationMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Blend what was told of known areas; copy what is believed of unknown ones."""
    belief = mind.belief
    for area in range(2):
        if not is_merged(belief, area, numbers):
            continue
        if belief.known[area] or is_copied(mind, area, numbers):
            merge_area(belief, area, float(mind.exchange.weight[area]), heard_p_share)
            belief.pending_from[area] = NOBODY


KERNELS: dict[str, Kernel] = {
    **SCEPTICAL_KERNELS,
    "take_in": take_in,
    "listen": listen_and_remember,
    "is_asked": is_asked,
    "merge": merge,
}
"""The functions of the estimator that the templates of a tick name."""


@ESTIMATORS.register("reputation_odometry")
class ReputationOdometryParameters(ScepticalOdometryParameters):
    """Sceptical odometry whose robots remember who told what, and how it turned out.

    Its numbers are those of sceptical odometry, and how reputations are made.
    """

    weighs_unknown: bool = Field(
        False,
        description="What is told of an area that the robot does not know is copied if the"
        " weighting gives it at least one half; false: if a second witness confirms it (chosen)",
    )
    slack: NotNegative = Field(
        0.3, description="What is told may be this far off and be right [m] (chosen)"
    )
    drift: NotNegative = Field(
        0.05, description="And this much farther for each metre travelled since (chosen)"
    )
    sure_within: NotNegative = Field(
        4.0,
        description="What is told is judged by the own place of the area within this path from the"
        " area [m] (chosen)",
    )
    remembers_within: NotNegative = Field(
        12.0, description="What was told is remembered for this path [m] (chosen)"
    )

    def layer(self, scenario: Scenario) -> EstimatorLayer:
        """The records and functions of the estimator, with its numbers in a scenario."""
        own = SGIKF().layer(scenario)
        names = ("weighs_unknown", "slack", "drift", "sure_within", "remembers_within")
        numbers = {**self.numbers(scenario), **{name: getattr(self, name) for name in names}}
        numbers["agreement"] = self.agreement
        return EstimatorLayer(ReputationMind, numbers, KERNELS, observe_world, own_weighting=own)
