"""Learning of a motion from transitions: behaviour cloning and reward-weighted regression.

Both maximise the likelihood of the recorded actions; the second weights each by its return:

    max_pi  sum_t w_t log pi(a_t | o_t)          w_t = 1 in behaviour cloning

Source: Peters2007, Reinforcement Learning by Reward-Weighted Regression for Operational Space
Control, in the form of Peng2019, Section 2, and of one iteration: the transitions are given.

Not in the paper: the discount covers several round trips, so that returns distinguish policies
rather than the phases of a round trip. Returns include an estimate of the rewards after the time
limit of the episode.
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
    """Options for learning from transitions."""

    temperature: float | None = None
    """Beta of `reward_weights`: lower values favour the best returns; None: equal weights."""
    discount: float = 0.9999
    """Discount factor of one decision in the returns."""
    batch: int = 1024
    """Transitions in a minibatch."""
    learning_rate: float = 1e-3


def discounted_returns(
    rewards: Float32[Array, "episodes decisions"], discount: float
) -> Float32[Array, "episodes decisions"]:
    """Return the discounted return of each decision.

        R_t = r_t + discount R_t+1,    R_T = mean(r) / (1 - discount)

    for an episode of T decisions; after its time limit it is continued with its mean reward.
    """
    after = discount * rewards.mean(axis=1, keepdims=True) / (1.0 - discount)
    returns, _ = lfilter([1.0], [1.0, -discount], rewards[:, ::-1], axis=1, zi=after)
    return np.ascontiguousarray(returns[:, ::-1], np.float32)


def reward_weights(
    returns: Float32[Array, " transitions"], temperature: float
) -> Float32[Array, " transitions"]:
    """Return the weight of each action from its return; the mean weight is 1.

        w = exp(R / beta) / mean(exp(R / beta))

    with the temperature beta, in units of the reward.

    Source: Peng2019, Section 2.
    """
    weights = np.exp((returns - returns.max()) / temperature)
    return np.asarray(weights / weights.mean(), np.float32)


class Cloner:
    """Learner of a policy from transitions, one minibatch at a time."""

    def __init__(self, played: Mapping[str, Array], options: CloningOptions) -> None:
        """Take the transitions of `training.transitions.read`: whole episodes of equal length."""
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
        """Take a gradient step on a random minibatch; return its weighted log-likelihood."""
        rows = torch.randint(len(self._acted), (self._batch,))
        mean = self.policy.actor(self._observed[rows])
        log_probs = log_probs_of(self._acted[rows], mean, self.policy.log_std)
        loss = -(self._weights[rows] * log_probs).mean()
        self._optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self._optimiser.step()
        return -loss.item()
