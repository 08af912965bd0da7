"""Global communication: every robot takes over the mean of what the whole group believes.

Gutierrez et al. 2008 (ANTS), Section 5: "each robot updates its estimates by averaging the
knowledge of the whole group". It is a reference, because averaging needs the true relative
poses of robots that do not see each other.

Not in the paper, and chosen here:
- the group averages once per exchange time of the radio, nobody stops for it, and nothing is
  lost or measured wrongly;
- the mean is over the robots that know the area, each counting alike; p becomes the mean of
  their p;
- a robot that knows nothing takes the mean over, and so is recruited at once; one that just got
  lost is deaf for `deaf_when_lost` first;
- a robot on an area is averaged like any other.
"""

import math

import numpy as np

from baselines.estimators.belief import Belief, SocialMind
from baselines.estimators.layer_inputs import describe
from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters
from baselines.estimators.social_odometry import take_in as take_in_odometry
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.foraging.records import Readings
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers, field


class GroupBelief(Belief):
    """What a robot believes that averages with the whole group."""

    ticks: int = field(np.int64, unit="ticks")
    """Ticks since reset, in which the group last averaged at a multiple of the period."""


class GroupMind(SocialMind):
    """All that global communication keeps of a robot."""

    belief: GroupBelief = field(GroupBelief)


@kernel
def move_between(
    x: float, y: float, pose: Float64[Array, "3"], to: Float64[Array, "3"]
) -> tuple[float, float]:
    """A place seen from `pose`, in the frame in which the same robot stands at `to` [m]."""
    angle = to[2] - pose[2]
    dx, dy = to_outer(x - pose[0], y - pose[1], math.cos(angle), math.sin(angle))
    return dx + to[0], dy + to[1]


@kernel
def average_area(swarm: Array, crowd: Array, area: int) -> None:
    """Put the mean of all who know an area in the place of the estimates of all who hear."""
    n = 0
    for i in range(crowd.shape[0]):
        n += crowd[i].belief.known[area]
    if n == 0:
        return
    share, mean_x, mean_y, mean_p = 1.0 / n, 0.0, 0.0, 0.0
    for i in range(crowd.shape[0]):
        belief = crowd[i].belief
        if belief.known[area]:
            place = belief.location[area]
            x, y = move_between(place[0], place[1], belief.pose, swarm[i].pose)
            mean_x += share * x
            mean_y += share * y
            mean_p += share * belief.p[area]
    for i in range(crowd.shape[0]):
        belief = crowd[i].belief
        if belief.ignore_ticks == 0:
            x, y = move_between(mean_x, mean_y, swarm[i].pose, belief.pose)
            belief.location[area, 0], belief.location[area, 1] = x, y
            belief.p[area] = mean_p
            belief.known[area] = True


@kernel
def take_in(mind: GroupMind, shared: Array, readings: Readings, numbers: Numbers) -> None:
    """Social odometry's tick, counted."""
    take_in_odometry(mind, shared, readings, numbers)
    mind.belief.ticks += 1


@kernel
def average(swarm: Array, crowd: Array, numbers: Numbers) -> None:
    """Average the estimates of one world, when it is time."""
    if crowd[0].belief.ticks % int(numbers.talk_ticks) == 0:
        for area in range(2):
            average_area(swarm, crowd, area)


def observe_group(
    robots: Array, minds: Array, shared: Array, settings: Array, first: int, last: int
) -> None:
    """Take in what was sensed, and average with everyone; there are no exchanges of two.

    Free names: take_in, average, describe.
    """
    for w in range(first, last):
        swarm, crowd = robots[w], minds[w]
        for i in range(swarm.shape[0]):
            take_in(crowd[i], shared[w, i], swarm[i].readings, settings[w, i].estimator)
        average(swarm, crowd, settings[w, 0].estimator)
        for i in range(swarm.shape[0]):
            describe(crowd[i], swarm[i].report)


class GlobalAverage(SocialOdometryParameters):
    """What social odometry leaves open; nobody broadcasts, all know all."""

    def layer(self, scenario: Scenario) -> EstimatorLayer:
        """The records and functions of the estimator, with its numbers in a scenario."""
        kernels: dict[str, Kernel] = {**KERNELS, "take_in": take_in, "average": average}
        own = SGIKF().layer(scenario)
        return EstimatorLayer(
            GroupMind, self.numbers(scenario), kernels, observe_group, own_weighting=own
        )
