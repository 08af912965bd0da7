"""Rewards: who is credited with what a robot earned, and how a potential shapes it."""

from collections.abc import Callable

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.registry import Registry

Reward = Callable[[Float64[Array, "worlds robots"]], Float64[Array, "worlds robots"]]

REWARDS: Registry[Reward] = Registry("reward")
"""Rewards by name: from what each robot earned to what each is given."""


@REWARDS.register("own")
def own(earned: Float64[Array, "worlds robots"]) -> Float64[Array, "worlds robots"]:
    """Each robot gets what it earned: 1 for completing nest -> prey -> nest."""
    return earned


@REWARDS.register("team")
def team(earned: Float64[Array, "worlds robots"]) -> Float64[Array, "worlds robots"]:
    """Every robot gets the mean over the robots of its world."""
    return np.broadcast_to(earned.mean(axis=1, keepdims=True), earned.shape)


def shaping(
    before: Float64[Array, " rows"],
    after: Float64[Array, " rows"],
    discount: float,
    weight: float,
) -> Float64[Array, " rows"]:
    """What a step between states of these potentials adds to the reward.

        weight (discount Phi' - Phi)

    The optimal policies stay as they are.

    Source: Ng1999, Theorem 1.
    """
    return np.asarray(weight * (discount * after - before))
