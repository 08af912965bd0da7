"""No odometry error: social odometry in which the believed pose follows the true motion.

Gutierrez et al. 2008 (ANTS), Section 5: "robots communicate and are not affected by odometry
errors".

Not in the paper, and chosen here:
- all else stays as it is: the beam is measured with its noise, the messages are lost, and what
  is heard is blended in by the weighting rule, although the own estimate is hardly wrong;
- the recipe's weighting is that of local communication there, the Fermi filter at beta = 1e-3;
- being pushed or blocked counts as the motion that it truly is, also in p;
- the own frame is the world frame: no layer can tell.
"""

from dataclasses import replace

import numpy as np

from baselines.estimators.reckoning import find_areas
from baselines.estimators.social_odometry import SocialOdometry, SocialOdometryParameters
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.ground_truth import GroundTruth
from swarm_forage_env.interface import Readings
from swarm_forage_env.compiler import kernel
from swarm_forage_env.kernels.diff_drive import path_length
from swarm_forage_env.kernels.frames import wrap
from swarm_forage_env.scenario import Scenario


class PerfectOdometry(SocialOdometryParameters):
    """What social odometry leaves open; the odometry is exact."""

    def start_knowing(
        self, scenario: Scenario, n_worlds: int, truth: GroundTruth
    ) -> "ExactOdometry":
        """The running estimator of a block of worlds."""
        return ExactOdometry(self, scenario, n_worlds, truth)


class ExactOdometry(SocialOdometry):
    """The estimates of robots that always know how they moved."""

    def __init__(
        self,
        parameters: SocialOdometryParameters,
        scenario: Scenario,
        n_worlds: int,
        truth: GroundTruth,
    ) -> None:
        """Robots that know where they stand, and of no area."""
        super().__init__(parameters, scenario, n_worlds)
        self._truth = truth
        self.beliefs.pose[:] = truth.pose

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world, and stand where its robots stand."""
        super().reset(world, seed)
        rows = slice(world * self._n_robots, (world + 1) * self._n_robots)
        self.beliefs.pose[rows] = self._truth.pose[rows]

    def _reckon(self, readings: Readings) -> Readings:
        """Follow the true motion, and find areas."""
        b = self.beliefs
        moved = np.empty((len(b.pose), 2), np.float32)
        follow(self._truth.pose, self._axle, b.pose, b.p, moved)
        find_areas(
            readings.ground, self._to_centre,
            b.pose, b.location, b.p, b.known, b.on_area, b.came_from, b.look_on,
        )  # fmt: skip
        return replace(readings, odometry=moved)


@kernel
def follow(
    true_pose: Float64[Array, "rows 3"],
    axle: float,
    pose: Float64[Array, "rows 3"],
    p: Float64[Array, "rows areas"],
    out_moved: Float32[Array, "rows 2"],
) -> None:
    """Move the believed pose to the true one, and let p grow by the way between them [m].

    out_moved: the distance, negative if backwards [m], and the turn [rad].
    """
    for i in range(pose.shape[0]):
        dx, dy = true_pose[i, 0] - pose[i, 0], true_pose[i, 1] - pose[i, 1]
        dtheta = wrap(true_pose[i, 2] - pose[i, 2])
        middle = pose[i, 2] + 0.5 * dtheta
        drho = np.hypot(dx, dy)
        if dx * np.cos(middle) + dy * np.sin(middle) < 0.0:
            drho = -drho
        pose[i, :] = true_pose[i]
        p[i, :] += path_length(drho, dtheta, axle)
        out_moved[i, 0], out_moved[i, 1] = drho, dtheta
