"""Exchanges with the true errors of both estimates: as training data, or as a reward.

The true errors are available in training only. A network can be fitted to recorded exchanges by
supervised learning; or a reward rates each weight at once, minutes before round trips do, so that
the weighting is learned as a contextual bandit.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor

from baselines.controller import LayeredController
from baselines.oracles.oracle import errors
from baselines.running import RunningLayers
from baselines.weighting.rows import RowWeighting
from swarm_forage_env.arrays import Array, Bool, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.control import is_weighed
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import FieldLayout
from swarm_forage_env.record import Rows, rows
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    REMEMBERED,
    REPUTATION_NETWORK,
    WeightingNetwork,
    network_over,
)
from training.policy_file import observation_layout
from training.tensor_vec_env import Step, TensorVecEnv

MAX_SQUARED_ERROR = 0.5
"""Upper bound of the squared error in the loss [m2]: a robot with an error of 0.7 m is lost."""

UNKNOWN_ERROR = 0.15
"""Squared error that stands for an unknown area in the loss [m2]: an error of 0.4 m."""

REWARD_UNIT = 0.01
"""Reduction of the squared error for a reward of 1 [m2]: that of an error of 10 cm."""

BATCH_SIZE = 1024  # exchanges of each scenario in a gradient step


def squared_error(g: Tensor, own: Tensor, heard: Tensor) -> Tensor:
    """Return the squared error of the merged estimate, at most `MAX_SQUARED_ERROR` [m2].

        |(1 - g) e_i + g e_j|^2

    e_i, e_j are the true errors of the own and of the heard estimate of the area [m].
    """
    merged = (1.0 - g)[:, None] * own + g[:, None] * heard
    return torch.clamp((merged**2).sum(1), max=MAX_SQUARED_ERROR)


def error_of_copying(g: Tensor, heard: Tensor) -> Tensor:
    """Return the expected squared error if an unknown area is copied with probability g [m2].

        (1 - g) c + g |e_j|^2

    c is `UNKNOWN_ERROR`, e_j the true error of the heard estimate [m].
    """
    copied = torch.clamp((heard**2).sum(1), max=MAX_SQUARED_ERROR)
    return (1.0 - g) * UNKNOWN_ERROR + g * copied


def error_reduction(g: Tensor, own: Tensor, heard: Tensor) -> Tensor:
    """Return the reduction of `squared_error` by an exchange with weight g [m2]."""
    return squared_error(torch.zeros_like(g), own, heard) - squared_error(g, own, heard)


Actor = Callable[[Tensor], Tensor]
"""Maps observations of exchanges to the weights of both areas."""


@dataclass(frozen=True)
class Exchanges:
    """Recorded exchanges, one row for each area whose estimate the exchange can change."""

    observed: Float32[Array, "rows numbers"]
    """Observation of each exchange; for the reputation network also the remembered features."""
    area: Float32[Array, "rows areas"]  # one-hot vector of the area
    known: Float32[Array, " rows"]  # 1 where the robot has an estimate of its own, else 0
    own_error: Float32[Array, "rows 2"]  # true error of the robot's own estimate of the area [m]
    heard_error: Float32[Array, "rows 2"]  # true error of the heard estimate [m]

    def __len__(self) -> int:
        return len(self.observed)

    @classmethod
    def of(cls, parts: Sequence["Exchanges"], n_features: int) -> "Exchanges":
        """Join exchanges whose observations have `n_features` features."""
        shapes = (0, n_features), (0, 2), (0,), (0, 2), (0, 2)
        nothing = [np.zeros(shape, np.float32) for shape in shapes]
        columns = zip(nothing, *(vars(each).values() for each in parts), strict=True)
        return cls(*(np.concatenate(each) for each in columns))

    def draw(self, draws: torch.Generator) -> "Exchanges":
        """Draw a batch with replacement."""
        chosen = torch.randint(len(self), (BATCH_SIZE,), generator=draws).numpy()
        return Exchanges(*(each[chosen] for each in vars(self).values()))

    def loss(self, g: Tensor) -> Tensor:
        """Return the squared error of each estimate after the exchange, with the weights g [m2]."""
        own, heard = torch.from_numpy(self.own_error), torch.from_numpy(self.heard_error)
        known = torch.from_numpy(self.known)
        return known * squared_error(g, own, heard) + (1.0 - known) * error_of_copying(g, heard)

    def error(self, actor: Actor) -> Tensor:
        """Return the mean squared error of the estimates that a network merges [m2]."""
        weights = actor(torch.from_numpy(self.observed))
        return self.loss((weights * torch.from_numpy(self.area)).sum(1)).mean()

    def gain(self, name: str) -> Tensor:
        """Return the mean error reduction by an oracle, which takes the better estimate [m2].

        ConfigError, with the `name` of the scenario, if it is zero.
        """
        nobody = torch.zeros(len(self))
        own, copied = self.loss(nobody), self.loss(nobody + 1.0)
        gain = (own - torch.minimum(own, copied)).mean()
        if not gain > 0.0:
            raise ConfigError(
                f"scenario '{name}': in {len(self)} exchanges no robot that knew an area"
                " received a better estimate of it, so that there is nothing to learn; use more"
                " --worlds, or worlds in which robots meet"
            )
        return gain

    def share(self, actor: Actor, gain: Tensor) -> float:
        """Return the error reduction by a network as a share of that by the oracle."""
        nobody = self.loss(torch.zeros(len(self))).mean()
        with torch.no_grad():
            return float((nobody - self.error(actor)) / gain)


@dataclass(frozen=True)
class RecordingWeighting:
    """Weighting by a network that records all exchanges with their true errors."""

    numbers: Float32[Array, " numbers"]  # flat weights of the network
    layout: FieldLayout  # layout of the observations that are recorded
    architecture: WeightingNetwork = EXCHANGE_NETWORK
    recorded: list[Exchanges] = field(default_factory=list)
    """Exchanges so far, in the order of the ticks in which they ended."""
    heard_p_share: ClassVar[float] = 1.0

    @property
    def remembers(self) -> bool:
        """Whether the network observes reputations and weighs areas unknown to the robot."""
        return self.architecture is REPUTATION_NETWORK

    def start_knowing(
        self, running: RunningLayers, world: ForagingWorld
    ) -> Callable[[Rows], Float32[Array, "rows areas"]]:
        """Start the weighting, with access to the beliefs and to the ground truth."""
        layer = self.architecture.layer(self.numbers, world.scenario)
        weigh = RowWeighting(layer, is_told if self.remembers else is_weighed)
        is_double = running.estimator.numbers["double"] > 0.0

        def record_and_weigh(exchange: Rows) -> Float32[Array, "rows areas"]:
            is_recorded = is_merged(exchange, is_double)
            if self.remembers:  # it also weighs areas that the robot does not know
                is_recorded |= (exchange.heard_known > 0.0) & ~(exchange.own_known > 0.0)
            row, area = np.nonzero(is_recorded)
            own, heard = errors(running.minds, world)
            observed = self.layout.matrix({"exchange": exchange})[row]
            if self.remembers:
                more = [exchange[name] for name in REMEMBERED]
                chosen = [each[row, area] if each.ndim > 1 else each[row] for each in more]
                observed = np.column_stack([observed, *chosen])
            known = exchange.own_known[row, area]
            columns = observed, np.eye(2)[area], known, own[row, area], heard[row, area]
            self.recorded.append(Exchanges(*(each.astype(np.float32) for each in columns)))
            return weigh(exchange)

        return record_and_weigh


def is_merged(exchange: Rows, is_double: bool) -> Bool[Array, "rows areas"]:
    """Return where both robots know the area, and the exchange is double or the area the goal."""
    is_known: Bool[Array, "rows areas"] = (exchange.heard_known > 0.0) & (exchange.own_known > 0.0)
    return is_known if is_double else is_known & (exchange.goal[:, :2] > 0.0)


@kernel
def is_told(exchange: Exchange, area: int) -> bool:
    """Return whether an estimate of the area was received."""
    return bool(exchange.heard_known[area])


def record_exchanges(
    scenario: Scenario,
    controller: LayeredController,
    numbers: Float32[Array, " numbers"],
    seeds: Sequence[int],
    physics: str,
) -> Exchanges:
    """Run whole episodes under a network, and return all exchanges with their true errors."""
    layout = observation_layout("weighting", scenario)
    weighting = RecordingWeighting(numbers, layout, network_over(controller.estimator))
    loop = Loop(scenario, replace(controller, weighting=weighting), seeds, physics)
    loop.run(scenario.n_ticks)
    n_features = len(layout) + (len(REMEMBERED) if weighting.remembers else 0)
    return Exchanges.of(weighting.recorded, n_features)


class ErrorRewardVecEnv(TensorVecEnv):
    """Environment that rewards the error reduction in an exchange instead of round trips.

    Its blocks use `step_on="exchange"` and an estimator that exchanges the positions of areas.
    """

    def step(self, actions: Tensor) -> Step:
        """Step all rows, with rewards in units of `REWARD_UNIT`."""
        g = torch.split((actions.cpu() + 1.0) / 2.0, self._n_rows)
        reduced = torch.cat(
            [_error_reduction_in(*each) for each in zip(self.blocks, g, strict=True)]
        )
        rewards = torch.where(self.acts, reduced.to(self.device) / REWARD_UNIT, 0.0)
        return super().step(actions)._replace(rewards=rewards)


def _error_reduction_in(block: ArrayEnv, g: Tensor) -> Tensor:
    """Return the error reduction by each learner's weights g, summed over both areas [m2]."""
    layers, world = block.download().loop.controller, block.world
    assert isinstance(layers, RunningLayers)
    assert isinstance(world, ForagingWorld)
    is_double = layers.estimator.numbers["double"] > 0.0
    merged = is_merged(rows(layers.minds["estimator"]["exchange"]), is_double)
    own, heard, counts = (
        torch.from_numpy(each.reshape(block.n_worlds, world.n_robots, *each.shape[1:]))[
            :, block.learner_numbers
        ].flatten(0, 2)
        for each in (*errors(layers.minds, world), merged)
    )
    reduced = error_reduction(g.flatten(), own.float(), heard.float())
    return torch.where(counts, reduced, 0.0).view(-1, 2).sum(1)
