"""Weighting of the oracle: select the estimate with the smaller true error.

Not in the paper: all of it. It is optimal among weighting rules with g in {0, 1} for a single
exchange; it bounds neither rules that blend estimates nor whole episodes.
"""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from baselines.running import RunningLayers
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.foraging.metrics import nearest_areas
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.record import Rows, rows


class OracleWeighting(Parameters):
    """Keep the own estimate or copy the heard one with its p, whichever has the smaller error."""

    heard_p_share: ClassVar[float] = 1.0

    def start_knowing(
        self, running: RunningLayers, world: ForagingWorld
    ) -> Callable[[Rows], Float32[Array, "rows areas"]]:
        """Return a rule: g = 1 if the heard estimate has the smaller error, else 0."""

        def weigh(exchange: Rows) -> Float32[Array, "rows areas"]:
            own, heard = errors(running.minds, world)
            nearer = np.hypot(*heard.T).T < np.hypot(*own.T).T
            return np.asarray(exchange.heard_known * nearer)

        return weigh


def errors(
    minds: Array, world: ForagingWorld
) -> tuple[Float64[Array, "rows areas 2"], Float64[Array, "rows areas 2"]]:
    """Return the true errors of the own and the heard estimates of the areas, world frame [m].

    They are meaningful only for areas that are known, or were heard of in an exchange.
    """
    beliefs = rows(minds["estimator"]["belief"])
    true_pose = world.state.pose
    weight = np.maximum(beliefs.heard_weight, 1.0)[:, :, None]
    own = moved(beliefs.location, beliefs.pose, true_pose)
    heard = moved(beliefs.heard_sum / weight, beliefs.pose, true_pose)
    return own - nearest_areas(world.worlds, own), heard - nearest_areas(world.worlds, heard)


def moved(
    location: Float64[Array, "rows areas 2"],
    pose: Float64[Array, "rows 3"],
    to: Float64[Array, "rows 3"],
) -> Float64[Array, "rows areas 2"]:
    """Transform places from the frame with the robot at `pose` to that with it at `to` [m]."""
    x, y = (location - pose[:, None, :2]).transpose(2, 0, 1)
    angle = (to[:, 2] - pose[:, 2])[:, None]
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack([c * x - s * y, s * x + c * y], axis=2)
    return np.asarray(turned + to[:, None, :2], np.float64)
