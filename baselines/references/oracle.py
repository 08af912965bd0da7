"""The oracle's weighting: of two estimates, the one that is truly nearer the area.

Not in the paper: all of it. It is the best that any weighting rule with g in {0, 1} can do in
one exchange; not a bound on what blending can do, nor on a whole episode.
"""

from typing import ClassVar

import numpy as np

from baselines.estimators.beliefs import Beliefs
from baselines.estimators.social_odometry import SocialOdometry
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.ground_truth import GroundTruth
from swarm_forage_env.interface import Encounter
from swarm_forage_env.scenario import Part


class OracleWeighting(Part):
    """Keep the own estimate, or take over the heard one with its p, whichever errs less."""

    def start_knowing(self, estimator: SocialOdometry, truth: GroundTruth) -> "Oracle":
        """The rule for robots that believe this, in worlds of which that is true."""
        return Oracle(estimator.beliefs, truth)


class Oracle:
    """g = 1 where the heard estimate errs less than the own one, else 0."""

    heard_p_share: ClassVar[float] = 1.0

    def __init__(self, beliefs: Beliefs, truth: GroundTruth) -> None:
        """Look at these beliefs in the light of this truth."""
        self._beliefs = beliefs
        self._truth = truth

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area."""
        own, heard = errors(self._beliefs, self._truth)
        nearer = np.hypot(*heard.T).T < np.hypot(*own.T).T
        g: Float32[Array, "rows areas"] = (encounter.heard_known & nearer).astype(np.float32)
        return g


def errors(
    beliefs: Beliefs, truth: GroundTruth
) -> tuple[Float64[Array, "rows areas 2"], Float64[Array, "rows areas 2"]]:
    """By how much the own and the heard places truly miss the areas, world frame [m].

    They mean something only where the place is known, or was heard in an exchange.
    """
    told = np.maximum(beliefs.heard_weight, 1.0)[:, :, None]
    own = in_world(beliefs.location, beliefs, truth) - truth.areas
    heard = in_world(beliefs.heard_sum / told, beliefs, truth) - truth.areas
    return own, heard


def in_world(
    location: Float64[Array, "rows areas 2"], beliefs: Beliefs, truth: GroundTruth
) -> Float64[Array, "rows areas 2"]:
    """Places of the robots' own frames where they truly are, world frame [m]."""
    return moved(location, beliefs.pose, truth.pose)


def moved(
    location: Float64[Array, "rows areas 2"],
    pose: Float64[Array, "rows 3"],
    to: Float64[Array, "rows 3"],
) -> Float64[Array, "rows areas 2"]:
    """Places seen from `pose`, in the frame in which the same robot stands at `to` [m]."""
    x, y = (location - pose[:, None, :2]).transpose(2, 0, 1)
    angle = (to[:, 2] - pose[:, 2])[:, None]
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack([c * x - s * y, s * x + c * y], axis=2)
    return np.asarray(turned + to[:, None, :2], np.float64)
