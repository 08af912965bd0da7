"""Rewards of a weighting: how much an exchange reduces the error of the robot's estimates.

The true error is known in training, and nowhere else. Round trips pay for a weight minutes after
it was chosen; this reward pays for it at once, so a weighting is learned as a contextual bandit.
"""

from dataclasses import replace

import torch
from torch import Tensor

from baselines.oracles.oracle import errors
from baselines.running import RunningLayers
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.record import rows
from training.exchanges import is_merged, squared_error
from training.tensor_vec_env import Step, TensorVecEnv

REWARD_UNIT = 0.01
"""Reduction of the squared error that earns a reward of 1 [m2]: that of an error of 10 cm."""


def error_reduction(g: Tensor, own: Tensor, heard: Tensor) -> Tensor:
    """How much smaller the squared error of an estimate is after an exchange with weight g [m2].

        |e_i|^2 - |(1 - g) e_i + g e_j|^2,   both at most `MAX_SQUARED_ERROR`

    e_i, e_j are the true errors of the own and of the heard estimate of the area [m].
    """
    return squared_error(torch.zeros_like(g), own, heard) - squared_error(g, own, heard)


class ErrorRewardVecEnv(TensorVecEnv):
    """Rewards a learner for the error reduction in its exchange, in the place of round trips.

    Its blocks step on exchanges, among robots that exchange the places of areas.
    """

    def step(self, actions: Tensor) -> Step:
        """One decision of all rows, with rewards in `REWARD_UNIT`."""
        g = torch.split((actions.cpu() + 1.0) / 2.0, self._n_rows)
        reduced = torch.cat(
            [_error_reduction_in(*each) for each in zip(self.blocks, g, strict=True)]
        )
        rewards = torch.where(self.acts, reduced.to(self.device) / REWARD_UNIT, 0.0)
        return replace(super().step(actions), rewards=rewards)


def _error_reduction_in(block: ArrayEnv, g: Tensor) -> Tensor:
    """What every learner's weights g, of both areas, would reduce its errors by now [m2]."""
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
