"""Reputation odometry: sceptical odometry in which robots judge each other's estimates.

Gutierrez et al. 2009 (TR), Sections 4 and 5, for social odometry. VanCalck2023, for the second
witness. JosangIsmail2002, The beta reputation system (15th Bled Electronic Commerce Conference),
for the reputations: the probability that a robot sends a right estimate is beta-distributed, given
its counts of right and of wrong estimates.

Not in the papers, and chosen here:
- the weighting can also apply to areas that the robot does not know (`weighs_unknown`): a received
  estimate is copied if its weight is at least one half, and otherwise only remembered;
- a received estimate is right if it lies within `slack` of the place where the area was found, plus
  `drift` times the path in between, as in the gate of `validation_gate`;
- the robot judges it when it enters the area, when it gets lost at the place where the area should
  be, or at once if it stood on the area itself within the last `sure_within` of its path;
- an estimate received more than `remembers_within` of path ago neither counts nor is judged;
- robots are identified by the number that they broadcast, which no robot forges;
- each robot keeps its reputations to itself: they are not exchanged;
- all choices of `sceptical_odometry`.
"""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.estimators.area_memory import update_belief as update_social_belief
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import NOBODY, NOWHERE
from baselines.estimators.message_exchange import (
    heard_place,
    is_merged,
    merge_area,
    update_exchange,
)
from baselines.estimators.sceptical_odometry import (
    ScepticalBelief,
    ScepticalMind,
    ScepticalOdometryParameters,
    is_confirmed,
)
from swarm_forage_env.arrays import Array, Float32, Int8
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.differential_drive import path_length
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.interface import Kernel
from swarm_forage_env.parameters import NotNegative
from swarm_forage_env.record import Numbers, Record, field

NEVER = -1.0


class Reputation(Record):
    """Memory of a robot about every other robot. Writer: `reputation_odometry`."""

    right: Float32[Array, " robots"] = field(np.float32, "robots")
    """Number of estimates of each robot that turned out right."""
    wrong: Float32[Array, " robots"] = field(np.float32, "robots")
    """Number of estimates of each robot that turned out wrong."""
    place: Float32[Array, "robots areas 2"] = field(np.float32, "robots", 2, 2, unit="m")
    """Last location of each area heard from each robot, own frame."""
    heard_at: Float32[Array, "robots areas"] = field(np.float32, "robots", 2, unit="m", start=NEVER)
    """Value of `path` when that location was heard; NEVER if none was."""
    is_open: Int8[Array, "robots areas"] = field(np.int8, "robots", 2)
    """Whether that location is not judged yet."""
    path: float = field(np.float64, unit="m")
    """Path length that the robot itself has travelled."""


class ReputationMind(ScepticalMind):
    """State of a robot under reputation odometry."""

    reputation: Reputation = field(Reputation)


@kernel
def trust(reputation: Reputation, other: int) -> float:
    """Return the expected share of right estimates of another robot.

        (r + 1) / (r + s + 2)

    r and s are the counts of right and of wrong estimates.

    Source: JosangIsmail2002, Definition 2 (the mean of the beta distribution).
    """
    right, wrong = float(reputation.right[other]), float(reputation.wrong[other])
    return (right + 1.0) / (right + wrong + 2.0)


@kernel
def path_since(reputation: Reputation, other: int, area: int) -> float:
    """Return the path since another robot sent an area [m]; infinite if it never did."""
    heard_at = float(reputation.heard_at[other, area])
    return math.inf if heard_at < 0.0 else float(reputation.path) - heard_at


@kernel
def is_near(
    reputation: Reputation, other: int, area: int, x: float, y: float, numbers: Numbers
) -> bool:
    """Return whether another robot's estimate of an area agrees with (x, y), own frame [m]."""
    dx, dy = reputation.place[other, area, 0] - x, reputation.place[other, area, 1] - y
    width = numbers.slack + numbers.drift * path_since(reputation, other, area)
    return bool(hypot(dx, dy) <= width)


@kernel
def judge(reputation: Reputation, other: int, area: int, is_right: bool) -> None:
    """Count another robot's estimate of an area as right or wrong."""
    count = reputation.right if is_right else reputation.wrong
    count[other] += 1.0
    reputation.is_open[other, area] = False


@kernel
def judge_all(
    reputation: Reputation, belief: ScepticalBelief, area: int, is_found: bool, numbers: Numbers
) -> None:
    """Judge the recent estimates of an area that the robot has just found, or failed to find."""
    x, y = belief.pose[0], belief.pose[1]
    if is_found:
        x, y = belief.location[area, 0], belief.location[area, 1]
    for other in range(reputation.is_open.shape[0]):
        is_recent = path_since(reputation, other, area) <= numbers.remembers_within
        if reputation.is_open[other, area] and is_recent:
            is_told_here = is_near(reputation, other, area, x, y, numbers)
            if is_found or is_told_here:
                judge(reputation, other, area, is_found and is_told_here)


@kernel
def remember(mind: ReputationMind, area: int, numbers: Numbers) -> None:
    """Store the heard estimate of an area; judge it at once if the own estimate is recent."""
    belief, reputation, other = mind.belief, mind.reputation, mind.belief.last_partner
    x, y = heard_place(belief, area)
    reputation.place[other, area, 0], reputation.place[other, area, 1] = x, y
    reputation.heard_at[other, area] = reputation.path
    reputation.is_open[other, area] = True
    if belief.visited[area] and belief.p[area] <= numbers.sure_within:
        dx, dy = x - belief.location[area, 0], y - belief.location[area, 1]
        width = numbers.slack + numbers.drift * (belief.p[area] + belief.heard_p[area])
        judge(reputation, other, area, bool(hypot(dx, dy) <= width))


@kernel
def describe_reputations(mind: ReputationMind, numbers: Numbers) -> None:
    """Write the reputations of the partner and of robots that agree or disagree to the exchange."""
    belief, reputation, exchange = mind.belief, mind.reputation, mind.exchange
    partner = belief.last_partner
    exchange.right, exchange.wrong = reputation.right[partner], reputation.wrong[partner]
    for area in range(2):
        support, suspicion, dissent = 0.0, 0.0, 0.0
        if belief.heard_weight[area] > 0.0:
            x, y = heard_place(belief, area)
            for other in range(reputation.is_open.shape[0]):
                if path_since(reputation, other, area) > numbers.remembers_within:
                    continue
                trusted = trust(reputation, other)
                if other != partner and is_near(reputation, other, area, x, y, numbers):
                    support += trusted
                    suspicion += 1.0 - trusted
                elif other != partner:
                    dissent += trusted
        exchange.support[area], exchange.suspicion[area] = support, suspicion
        exchange.dissent[area] = dissent
        exchange.own_visited[area] = belief.visited[area]


COPIED_FROM = 0.5  # least weight with which the location of an unknown area is copied


@kernel
def update_belief(
    mind: ReputationMind, shared: Array, readings: Readings, numbers: Numbers
) -> None:
    """Update the belief as social odometry does; judge estimates of an area found or not found."""
    belief, odometry = mind.belief, readings.odometry
    before, goal = belief.on_area, belief.goal
    mind.reputation.path += path_length(float(odometry[0]), float(odometry[1]), numbers.axle)
    update_social_belief(mind, shared, readings, numbers)
    if belief.on_area != NOWHERE and belief.on_area != before:
        judge_all(mind.reputation, belief, belief.on_area, True, numbers)
    if belief.is_lost:
        judge_all(mind.reputation, belief, goal, False, numbers)


@kernel
def listen_and_remember(minds: Array, i: int, heard: Heard, numbers: Numbers) -> bool:
    """Update the exchange of robot i; at its end, store its estimates. Returns whether it ended."""
    has_ended = update_exchange(minds, i, heard, numbers)
    if has_ended:
        describe_reputations(minds[i], numbers)
        for area in range(2):
            if minds[i].belief.heard_weight[area] > 0.0:
                remember(minds[i], area, numbers)
    return has_ended


@kernel
def needs_weight(exchange: Exchange, area: int, numbers: Numbers) -> bool:
    """Return whether the area is weighed: the partner or, unless `weighs_unknown`, both know it."""
    is_weighed = exchange.own_known[area] or numbers.weighs_unknown > 0.0
    return bool(exchange.heard_known[area]) and bool(is_weighed)


@kernel
def is_copied(mind: ReputationMind, area: int, numbers: Numbers) -> bool:
    """Return whether the heard estimate of an unknown area is copied."""
    if numbers.weighs_unknown > 0.0:
        return bool(mind.exchange.weight[area] >= COPIED_FROM)
    return is_confirmed(mind.belief, area, numbers.agreement)


@kernel
def merge(mind: ReputationMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Blend heard estimates of known areas; copy the trusted ones of unknown areas."""
    belief = mind.belief
    for area in range(2):
        if not is_merged(belief, area, numbers):
            continue
        if belief.known[area] or is_copied(mind, area, numbers):
            merge_area(belief, area, float(mind.exchange.weight[area]), heard_p_share)
            belief.pending_sender[area] = NOBODY


@ESTIMATORS.register("reputation_odometry")
class ReputationOdometryParameters(ScepticalOdometryParameters):
    """Sceptical odometry in which robots remember and judge each other's estimates."""

    mind = ReputationMind
    kernels: ClassVar[Mapping[str, Kernel]] = {
        **ScepticalOdometryParameters.kernels,
        "update_belief": update_belief,
        "update_exchange": listen_and_remember,
        "needs_weight": needs_weight,
        "merge": merge,
    }

    weighs_unknown: bool = Field(
        False,
        description="Whether the estimate of an area that the robot does not know is copied if"
        " its weight is at least one half; false: if a second witness confirms it (chosen)",
    )
    slack: NotNegative = Field(
        0.3, description="Largest error at which a received estimate counts as right [m] (chosen)"
    )
    drift: NotNegative = Field(
        0.05, description="Growth of this error for each metre travelled since (chosen)"
    )
    sure_within: NotNegative = Field(
        4.0,
        description="Path from an area within which its own place of it judges received"
        " estimates [m] (chosen)",
    )
    remembers_within: NotNegative = Field(
        12.0, description="Path for which received estimates are remembered [m] (chosen)"
    )
