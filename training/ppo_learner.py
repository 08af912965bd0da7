"""PPO in tensors that stay where the worlds are: policy, rollouts and updates on one device.

The update is that of stable-baselines3, with its defaults for what `PPOHyperparameters` does not
name; `tests/training/test_ppo_learner.py` compares the two.

Source: Schulman2017, Proximal Policy Optimization Algorithms.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor

from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from training.tensor_vec_env import TensorVecEnv

if TYPE_CHECKING:
    from stable_baselines3.common.policies import ActorCriticPolicy

    from training.actor_critic import LayerPolicy

CLIP_RANGE = 0.2
"""Clipping of the ratio of probabilities after and before: as stable-baselines3."""


@dataclass(frozen=True)
class Rollout:
    """Transitions of a rollout, decisions by rows."""

    observations: Tensor
    actions: Tensor
    log_probs: Tensor
    values: Tensor
    """Of the observations; one decision more than the others."""
    rewards: Tensor
    """At the end of an episode with the discounted value of its last observation."""
    ends: Tensor
    """1 where an episode ends with the decision, else 0."""


def advantages(rollout: Rollout, discount: float, gae_lambda: float) -> Tensor:
    """Generalised advantage estimates, decisions by rows.

        delta_t = r_t + discount v_{t+1} - v_t
        A_t     = delta_t + discount lambda A_{t+1}

    where v_{t+1} and A_{t+1} are 0 if an episode ends at t.

    Source: Schulman2016, Eq. 16.
    """
    out = torch.empty_like(rollout.rewards)
    later = torch.zeros_like(rollout.rewards[0])
    for k in reversed(range(len(out))):
        decay = discount * (1.0 - rollout.ends[k])
        delta = rollout.rewards[k] + decay * rollout.values[k + 1] - rollout.values[k]
        out[k] = later = delta + decay * gae_lambda * later
    return out


def clipped_loss(ratio: Tensor, gains: Tensor) -> Tensor:
    """The clipped surrogate loss of a minibatch, whose advantages are normalised.

    Source: Schulman2017, Eq. 7.
    """
    normal = (gains - gains.mean()) / (gains.std() + 1e-8)
    clipped = torch.clamp(ratio, 1.0 - CLIP_RANGE, 1.0 + CLIP_RANGE)
    return -torch.min(normal * ratio, normal * clipped).mean()


def policy_change(log_ratio: Tensor) -> dict[str, float]:
    """How far an update moved the policy, from log probabilities after less those before."""
    ratio = torch.exp(log_ratio)
    return {
        "train/approx_kl": (ratio - 1.0 - log_ratio).mean().item(),
        "train/clip_fraction": ((ratio - 1.0).abs() > CLIP_RANGE).float().mean().item(),
    }


VALUE_WEIGHT, MAX_GRADIENT_NORM = 0.5, 0.5
"""Weight of the critic's loss, clipping of the gradient: as SB3."""

ADAM_EPSILON = 1e-5
"""Of Adam's denominator: as SB3."""

MAX_ROLLOUT, MIN_MINIBATCH = 2**20, 2**15
"""Decisions of a rollout, at most about, and of a minibatch, at least, unless a rollout has less
than its number of minibatches of them."""

MIN_STEPS = 16
"""Decisions of each row in a rollout, at least."""

MOMENTS = ("step", "exp_avg", "exp_avg_sq")
"""Entries of Adam's state for each parameter."""


@dataclass(frozen=True)
class PPOHyperparameters:
    """Hyperparameters of PPO."""

    decision_period: int = 2
    """Ticks for which an action is held. An exchange takes a few ticks, during which a robot must
    stop: a longer period would miss it."""
    discount: float = 0.998
    """Discount factor of one decision; the mean horizon is 100 s, about a round trip."""
    gae_lambda: float = 0.98
    """Lambda of generalised advantage estimation."""
    shaping: float = 1.0
    """Weight of the potential-based reward shaping."""
    n_steps: int = 256
    """Decisions of each robot in one rollout, at most."""
    n_minibatches: int = 4
    """Minibatches per rollout and epoch, at least."""
    n_epochs: int = 4
    learning_rate: float = 4e-4
    """Initial learning rate; it falls linearly to zero over the budget."""
    log_std: float = -1.2
    """Initial logarithm of the standard deviation of the actions."""


class PPOLearner:
    """PPO on the rows of an environment, with parameter sharing: one policy for all.

    env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=1024, physics="kinematic")])
    policy = ActorCriticPolicy(env.observation_space, env.action_space, lambda _: 3e-4)
    learner = PPOLearner(env, policy, PPOHyperparameters(decision_period=10))
    learner.learn(10**6, learning_rate=3e-4, seed=0)
    """

    def __init__(
        self,
        env: TensorVecEnv,
        policy: "LayerPolicy | ActorCriticPolicy",
        hyperparameters: PPOHyperparameters,
    ) -> None:
        """Move a policy to the device of the environment, to be trained there.

        Of the hyperparameters those of the learner count; the others are the environment's.
        """
        if not isinstance(env.action_space, Box):
            raise ConfigError("discrete: PPO in tensors gives numbers, not choices; leave it out")
        self.env, self._hyperparameters = env, hyperparameters
        self.policy = policy.to(env.device)
        self._optimizer = torch.optim.Adam(self.policy.parameters(), eps=ADAM_EPSILON)
        self.n_decisions = 0
        """Decisions of single rows so far."""
        self.diagnostics: dict[str, float] = {}
        """Losses and the like of the last update, by the name of their curve."""
        self._low = torch.from_numpy(env.action_space.low).to(env.device)
        self._high = torch.from_numpy(env.action_space.high).to(env.device)
        self._observations: Tensor | None = None

    @property
    def n_steps(self) -> int:
        """Decisions of each row in a rollout: fewer where there are many rows."""
        return min(self._hyperparameters.n_steps, max(MIN_STEPS, MAX_ROLLOUT // self.env.n_rows))

    def learn(self, decisions: int, learning_rate: float, seed: int | None = None) -> None:
        """Learn from this number of decisions of single rows, in whole rollouts.

        A seed resets all worlds, and seeds them and torch; without one the worlds go on.
        """
        if seed is not None or self._observations is None:
            torch.manual_seed(seed or 0)
            self.env.seed(seed or 0)
            self._observations = self.env.reset()
        for group in self._optimizer.param_groups:
            group["lr"] = learning_rate
        goal = self.n_decisions + decisions
        while self.n_decisions < goal:
            rollout, self._observations = self._roll_out(self._observations)
            self._update(rollout)

    def state(self) -> dict[str, Array]:
        """Parameters, Adam's moments and the number of decisions, by name."""
        tensors = {f"policy.{name}": each for name, each in self.policy.state_dict().items()}
        for name, parameter in self.policy.named_parameters():
            moments = self._optimizer.state.get(parameter, {})
            for moment in MOMENTS:
                empty = torch.zeros(() if moment == "step" else parameter.shape)
                tensors[f"{moment}.{name}"] = moments.get(moment, empty)
        arrays = {name: each.detach().cpu().numpy().copy() for name, each in tensors.items()}
        return arrays | {"n_decisions": np.array(self.n_decisions)}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Set what `state` returned; the next call of `learn` needs a seed to go on alike."""
        tensors = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
        names = self.policy.state_dict()
        self.policy.load_state_dict({name: tensors[f"policy.{name}"] for name in names})
        for name, parameter in self.policy.named_parameters():
            if tensors[f"step.{name}"] > 0:
                moments = {moment: tensors[f"{moment}.{name}"] for moment in MOMENTS}
                self._optimizer.state[parameter] = {
                    k: each if k == "step" else each.to(parameter.device)
                    for k, each in moments.items()
                }
        self.n_decisions = int(arrays["n_decisions"])

    @torch.no_grad()
    def _roll_out(self, observations: Tensor) -> tuple[Rollout, Tensor]:
        """Let all rows act for `n_steps` decisions; also return the observations after these.

        Episodes end by a time limit only, so the critic's value of the last observation stands for
        the rewards that would follow.
        """
        n, env, policy = self.n_steps, self.env, self.policy
        rollout = self._empty_rollout(observations)
        policy.train(False)
        for k in range(n):
            actions, values, log_probs = policy(observations)
            step = env.step(torch.clamp(actions, self._low, self._high))
            rollout.observations[k], rollout.actions[k] = observations, actions
            rollout.log_probs[k], rollout.values[k] = log_probs, values.flatten()
            rollout.rewards[k] = step.rewards
            if len(step.ended):
                final = policy.predict_values(step.final_observations[step.ended]).flatten()
                rollout.rewards[k, step.ended] += self._hyperparameters.discount * final
                rollout.ends[k, step.ended] = 1.0
            observations = step.observations
        rollout.values[n] = policy.predict_values(observations).flatten()
        self.n_decisions += n * env.n_rows
        return rollout, observations

    def _empty_rollout(self, observations: Tensor) -> Rollout:
        n, n_rows = shape = self.n_steps, self.env.n_rows
        return Rollout(
            observations=observations.new_empty((*shape, observations.shape[1])),
            actions=observations.new_empty((*shape, len(self._low))),
            log_probs=observations.new_empty(shape),
            values=observations.new_empty((n + 1, n_rows)),
            rewards=observations.new_empty(shape),
            ends=observations.new_zeros(shape),
        )

    def _update(self, rollout: Rollout) -> None:
        terms, policy = self._hyperparameters, self.policy
        gains = advantages(rollout, terms.discount, terms.gae_lambda)
        returns = (gains + rollout.values[:-1]).flatten()
        seen, actions = rollout.observations.flatten(0, 1), rollout.actions.flatten(0, 1)
        before, gains = rollout.log_probs.flatten(), gains.flatten()
        n_minibatches = max(terms.n_minibatches, len(gains) // MIN_MINIBATCH)
        policy.train(True)
        for _ in range(terms.n_epochs):
            shuffled = torch.randperm(len(gains), device=gains.device)
            for rows in shuffled.tensor_split(n_minibatches):
                values, log_probs, _ = policy.evaluate_actions(seen[rows], actions[rows])
                log_ratio = log_probs - before[rows]
                actor_loss = clipped_loss(torch.exp(log_ratio), gains[rows])
                critic_loss = torch.nn.functional.mse_loss(values.flatten(), returns[rows])
                self._descend(actor_loss + VALUE_WEIGHT * critic_loss)
        self.diagnostics = {
            "train/policy_gradient_loss": actor_loss.item(),
            "train/value_loss": critic_loss.item(),
            "train/std": torch.exp(policy.log_std).mean().item(),
            "train/reward": rollout.rewards.mean().item(),
            **policy_change(log_ratio.detach()),
        }

    def _descend(self, loss: Tensor) -> None:
        """Take a step of Adam along the clipped gradient of a loss."""
        self._optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.policy.parameters(), MAX_GRADIENT_NORM)
        self._optimizer.step()
