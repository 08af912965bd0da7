"""Learn a motion from its transitions: behaviour cloning, and reward-weighted regression.

Both make the recorded actions likely; the second counts each by what was earned after it:

    max_pi  sum_t w_t log pi(a_t | o_t)          w_t = 1 in behaviour cloning

Source: Peters2007, Reinforcement Learning by Reward-Weighted Regression for Operational Space
Control, in the form of Peng2019, Section 2, and of one iteration: the transitions are given.

Not in the paper: the discount looks far ahead, over several round trips, so that returns tell
policies apart rather than the phases of a round trip. What an episode would earn after its end,
which is its time, stands in its returns.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from scipy.signal import lfilter

from swarm_forage_env.arrays import Array, Float32
from training.actor_critic import ActorCritic, log_probs_of


@dataclass(frozen=True)
class CloningOptions:
    """How a policy learns from transitions."""

    temperature: float | None = None
    """Beta of `reward_weights`: the less, the more the best returns count; None: all alike."""
    discount: float = 0.9999
    """Of a decision, in returns."""
    batch: int = 1024
    """Transitions in a minibatch."""
    learning_rate: float = 1e-3


def discounted_returns(
    rewards: Float32[Array, "episodes decisions"], discount: float
) -> Float32[Array, "episodes decisions"]:
    """What is earned from each decision on.

        R_t = r_t + discount R_t+1,    R_T = mean(r) / (1 - discount)

    for an episode of T decisions, which its time ends: as if it went on as it was on average.
    """
    after = discount * rewards.mean(axis=1, keepdims=True) / (1.0 - discount)
    returns, _ = lfilter([1.0], [1.0, -discount], rewards[:, ::-1], axis=1, zi=after)
    return np.ascontiguousarray(returns[:, ::-1], np.float32)


def reward_weights(
    returns: Float32[Array, " transitions"], temperature: float
) -> Float32[Array, " transitions"]:
    """How much actions count, by the returns after them; 1 on average.

        w = exp(R / beta) / mean(exp(R / beta))

    with the temperature beta, in units of the reward.

    Source: Peng2019, Section 2.
    """
    weights = np.exp((returns - returns.max()) / temperature)
    return np.asarray(weights / weights.mean(), np.float32)


class Cloner:
    """Learns from transitions, a minibatch at a time."""

    def __init__(self, played: Mapping[str, Array], options: CloningOptions) -> None:
        """Start from what `training.transitions.read` gives: whole episodes, each as long."""
        self._observed, self._acted = (
            torch.from_numpy(played[name]) for name in ("observation", "action")
        )
        weights = np.ones(len(self._acted), np.float32)
        if options.temperature is not None:
            rewards = played["reward"].reshape(played["truncated"].sum(), -1)
            returns = discounted_returns(rewards, options.discount)
            weights = reward_weights(returns.ravel(), options.temperature)
        self._weights, self._batch = torch.from_numpy(weights), options.batch
        self.policy = ActorCritic(self._observed.shape[1], self._acted.shape[1])
        self._optimiser = torch.optim.Adam(self.policy.parameters(), lr=options.learning_rate)

    def step(self) -> float:
        """Learn from a minibatch, drawn from all transitions; its weighted log-likelihood."""
        rows = torch.randint(len(self._acted), (self._batch,))
        mean = self.policy.actor(self._observed[rows])
        log_probs = log_probs_of(self._acted[rows], mean, self.policy.log_std)
        loss = -(self._weights[rows] * log_probs).mean()
        self._optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self._optimiser.step()
        return -loss.item()
