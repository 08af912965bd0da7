"""Rewards: who is credited with a round trip, and the potential that may shape it."""

from collections.abc import Callable

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.registry import Registry
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.state import SwarmState

Reward = Callable[[Float64[Array, "worlds robots"]], Float64[Array, "worlds robots"]]

REWARDS: Registry[Reward] = Registry("reward")
"""Rewards by name: from what each robot earned to what each is given."""

LEGS = 3
"""To the first nest, to the prey, back to the nest."""


@REWARDS.register("own")
def own(earned: Float64[Array, "worlds robots"]) -> Float64[Array, "worlds robots"]:
    """Each robot gets what it earned: 1 for completing nest -> prey -> nest."""
    return earned


@REWARDS.register("team")
def team(earned: Float64[Array, "worlds robots"]) -> Float64[Array, "worlds robots"]:
    """Every robot gets the mean over the robots of its world."""
    return np.broadcast_to(earned.mean(axis=1, keepdims=True), earned.shape)


class Shaping:
    """What a step between two states adds to the reward, for a potential of the state.

        weight (discount Phi' - Phi)

    Source: Ng1999, Theorem 1.
    """

    def __init__(self, discount: float, weight: float) -> None:
        """Of a learner's discount, with this weight."""
        self._discount = discount
        self._weight = weight

    def shaping(
        self, before: Float64[Array, " rows"], after: Float64[Array, " rows"]
    ) -> Float64[Array, " rows"]:
        """What a step between states of these potentials adds to the reward."""
        return np.asarray(self._weight * (self._discount * after - before))


class Potential(Shaping):
    """How far each robot is on its round trip: a function of the true state, in [0, 1].

        Phi = (leg + 1 - d / far) / 3

    leg counts nest (first visit), prey, nest; d is the true distance to the centre of the area
    that leg leads to [m], far the largest distance possible in the arena [m]. Shaping adds
    weight (discount Phi' - Phi) to the reward of a step from a state to the next, which leaves
    the optimal policies as they are. Not in the paper: the potential itself; and an episode
    that is cut short keeps the potential of its last state, as its value is bootstrapped.

    Source: Ng1999, Theorem 1.
    """

    def __init__(self, scenario: Scenario, discount: float, weight: float) -> None:
        """The potential of a scenario's arena."""
        super().__init__(discount, weight)
        self._areas = scenario.areas
        x, y = 0.5 * scenario.arena.length, 0.5 * scenario.arena.width
        self._far = float(np.hypot(x + self._areas[1, 0], y))

    def __call__(self, state: SwarmState) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        way = self._areas[state.leg % 2] - state.pose[:, :2]  # legs lead to areas 0, 1, 0
        d = np.hypot(way[:, 0], way[:, 1])
        return np.asarray((state.leg + 1.0 - np.minimum(d / self._far, 1.0)) / LEGS)
