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

import numpy as np

from baselines.estimators.social_odometry import SocialOdometry, SocialOdometryParameters
from baselines.references.oracle import in_world, moved
from swarm_forage_env.arrays import Array, Bool, Float64, Int64
from swarm_forage_env.ground_truth import GroundTruth
from swarm_forage_env.interface import Heard
from swarm_forage_env.scenario import Scenario


class GlobalAverage(SocialOdometryParameters):
    """What social odometry leaves open; nobody broadcasts, all know all."""

    def start_knowing(
        self, scenario: Scenario, n_worlds: int, truth: GroundTruth
    ) -> "GlobalOdometry":
        """The running estimator of a block of worlds."""
        return GlobalOdometry(self, scenario, n_worlds, truth)


class GlobalOdometry(SocialOdometry):
    """The estimates of robots that average with everyone."""

    def __init__(
        self,
        parameters: SocialOdometryParameters,
        scenario: Scenario,
        n_worlds: int,
        truth: GroundTruth,
    ) -> None:
        """Robots that know nothing yet."""
        super().__init__(parameters, scenario, n_worlds)
        self._truth = truth
        self._period = max(1, round(scenario.radio.exchange_time / scenario.tick))
        self._ticks: Int64[Array, " worlds"] = np.zeros(n_worlds, np.int64)

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        super().reset(world, seed)
        self._ticks[world] = 0

    def _talk(self, heard: Heard) -> Bool[Array, " rows"]:
        """Average with everyone, when it is time; nobody converses."""
        self._ticks += 1
        due = self._ticks % self._period == 0
        if due.any():
            self._average(np.repeat(due, self._n_robots))
        return np.zeros(len(due) * self._n_robots, np.bool_)

    def _average(self, due: Bool[Array, " rows"]) -> None:
        """Put the mean of each world in the place of all estimates of robots that hear."""
        b = self.beliefs
        place, known = in_world(b.location, b, self._truth), b.known & due[:, None]
        mean, p = np.empty_like(place), np.empty_like(b.p)
        listening = (due & (b.deaf == 0))[:, None] & self._mean(place, b.p, known, mean, p)
        np.copyto(b.location, moved(mean, self._truth.pose, b.pose), where=listening[:, :, None])
        np.copyto(b.p, p, where=listening)
        np.logical_or(b.known, listening, out=b.known)

    def _mean(
        self,
        place: Float64[Array, "rows areas 2"],
        p: Float64[Array, "rows areas"],
        known: Bool[Array, "rows areas"],
        out_place: Float64[Array, "rows areas 2"],
        out_p: Float64[Array, "rows areas"],
    ) -> Bool[Array, "rows areas"]:
        """Means over those that know, for every robot of their world; if anybody knows."""
        knowing = known.reshape(-1, self._n_robots, 2)
        count = knowing.sum(axis=1, keepdims=True)
        weight = knowing / np.maximum(count, 1)
        shape = (*knowing.shape, 2)
        mean = (weight[..., None] * place.reshape(shape)).sum(axis=1, keepdims=True)
        mean_p = (weight * p.reshape(knowing.shape)).sum(axis=1, keepdims=True)
        out_place[:] = np.broadcast_to(mean, shape).reshape(place.shape)
        out_p[:] = np.broadcast_to(mean_p, knowing.shape).reshape(p.shape)
        return np.broadcast_to(count > 0, knowing.shape).reshape(p.shape)
