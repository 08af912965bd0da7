"""PPO in tensors that stay where the worlds are: policy, rollouts and updates on one device.

The update is that of stable-baselines3, with its defaults for what `PPOHyperparameters` does not
name; `tests/training/test_ppo_learner.py` compares the two.

Source: Schulman2017, Proximal Policy Optimization Algorithms.
"""

from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from training.actor_critic import ActorCritic, RecurrentActorCritic
from training.cuda_graphs import Graphed, Repeated, Work
from training.tensor_vec_env import Step, TensorVecEnv

if TYPE_CHECKING:
    from stable_baselines3.common.policies import ActorCriticPolicy

CLIP_RANGE = 0.2
"""Clipping of the ratio of probabilities after and before: as stable-baselines3."""


@dataclass(frozen=True)
class Rollout:
    """Transitions of a rollout, decisions by rows."""

    states: Tensor
    """Of the rows before the first decision: rows by numbers, none for a policy without memory."""
    observations: Tensor
    """One decision more than actions."""
    actions: Tensor
    log_probs: Tensor
    values: Tensor
    """Of the observations; one decision more than the others."""
    rewards: Tensor
    """At the end of an episode with the discounted value of its last observation."""
    ends: Tensor
    """1 where an episode ends with the decision, else 0."""
    acts: Tensor
    """True where the action counts."""


def advantages(rollout: Rollout, discount: float, gae_lambda: float) -> Tensor:
    """Generalised advantage estimates, decisions by rows.

        delta_t = r_t + discount v_{t+1} - v_t
        A_t     = delta_t + discount lambda A_{t+1}

    where v_{t+1} and A_{t+1} are 0 if an episode ends at t. Where the action at t + 1 does not
    count, lambda is 1: so the reward until the next action that counts is credited to this one,
    and only there a value stands in for what follows. Sums over 1, 2, 4 ... decisions are made of
    sums over half as many, for all decisions at once.

    Source: Schulman2016, Eq. 16; that only actions that count are steps: Sutton1999, options.
    """
    ends, values = rollout.ends, rollout.values
    later = discount * (1.0 - ends)
    gains = rollout.rewards + later * values[1:] - values[:-1]
    decays = later[:-1] * torch.where(rollout.acts[1:], gae_lambda, 1.0)
    span = 1
    while span < len(gains):
        gains = torch.cat((gains[:-span] + decays * gains[span:], gains[-span:]))
        decays, span = decays[:-span] * decays[span:], 2 * span
    return gains


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
    """Hyperparameters of PPO; by default stable-baselines3's, but for rollout and rate."""

    discount: float = 0.99
    """Discount factor of one decision."""
    gae_lambda: float = 0.95
    """Lambda of generalised advantage estimation."""
    n_steps: int = 128
    """Decisions of each robot in one rollout, at most."""
    n_minibatches: int = 20
    """Minibatches per rollout and epoch, at least."""
    n_epochs: int = 10
    learning_rate: float = 7e-4
    rows_together: int = 1
    """Rows of a decision that share a minibatch: the robots of a world, for a network over them."""


Losses = tuple[Tensor, ...]
"""Those of actor and critic in a minibatch, and the logarithms of the ratios of its actions."""


def _adam(weights: Iterator[nn.Parameter], rate: float) -> torch.optim.Adam:
    """Adam, whose moments are zeros; on a GPU it can be a part of a graph."""
    parameters = list(weights)
    device = parameters[0].device
    on_gpu = device.type == "cuda"
    usable = torch.tensor(rate, device=device) if on_gpu else rate
    adam = torch.optim.Adam(
        parameters, usable, eps=ADAM_EPSILON, fused=on_gpu or None, capturable=on_gpu
    )
    for each in parameters:
        zeros = torch.zeros((), device=device), torch.zeros_like(each), torch.zeros_like(each)
        adam.state[each] = dict(zip(MOMENTS, zeros, strict=True))
    return adam


def _tensors_of(policy: nn.Module, adam: torch.optim.Adam) -> dict[str, Tensor]:
    """What an update changes, by name: parameters, and what Adam keeps of each."""
    named = {f"policy.{name}": each for name, each in policy.state_dict().items()}
    for name, parameter in policy.named_parameters():
        named |= {f"{moment}.{name}": each for moment, each in adam.state[parameter].items()}
    return named


def _n_acting(acts: Tensor) -> int:
    """How many actions count; ConfigError where they are too few to compare their advantages."""
    n = int(acts.sum())
    if n < 2:
        raise ConfigError(
            f"step_on='exchange': {n} exchanges in a rollout, which is too few to learn from; take"
            " more robots or worlds"
        )
    return n


def _groups_that_act(acts: Tensor, groups: Tensor, why: str) -> Tensor:
    """Which groups act; ConfigError where actions of a part of one count."""
    counts = acts.flatten()[groups]
    if (counts.any(1) != counts.all(1)).any():
        raise ConfigError(
            f"{why}: actions of some of these rows count and of others do not; leave"
            " step_on='exchange' out"
        )
    return counts.all(1)


def _minibatches(groups: Tensor, acts: Tensor, n: int) -> Iterator[tuple[Tensor, ...]]:
    """Rows in n parts, each those whose actions count, and those whose do not."""
    parts = groups[acts].tensor_split(n), groups[~acts].tensor_split(n)
    return zip(*([each.flatten() for each in part] for part in parts), strict=True)


class PPOLearner:
    """PPO on the rows of an environment, with parameter sharing: one policy for all.

    env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=1024, physics="kinematic")])
    policy = ActorCritic(len(env.observation_layout), *env.action_space.shape)
    learner = PPOLearner(env, policy, PPOHyperparameters())
    learner.learn(10**7, seed=0)
    """

    def __init__(
        self,
        env: TensorVecEnv,
        policy: "ActorCritic | ActorCriticPolicy",
        hyperparameters: PPOHyperparameters,
    ) -> None:
        """Move a policy to the device of the environment, to be trained there."""
        if not isinstance(env.action_space, Box):
            raise ConfigError("discrete: PPO in tensors gives numbers, not choices; leave it out")
        together = hyperparameters.rows_together
        if together < 1 or env.n_rows % together:
            raise ConfigError(
                f"rows_together={together}: must divide the {env.n_rows} rows"
                " of the environment; take the number of robots of a world"
            )
        if isinstance(policy, RecurrentActorCritic) and together > 1:
            raise ConfigError(
                f"rows_together={together}: a network with memory takes whole rows, one by one;"
                " leave it out"
            )
        low, high = env.action_space.low, env.action_space.high
        self.env, self._hyperparameters = env, hyperparameters
        self.policy = policy.to(env.device)
        self._optimizer = _adam(self.policy.parameters(), hyperparameters.learning_rate)
        self._tensors = _tensors_of(self.policy, self._optimizer)
        self._learn: Work = self._learn_from
        self._repeated: Repeated | None = None
        if env.device.type == "cuda" and type(self.policy) is ActorCritic:
            self._learn = Graphed(self._learn_from, list(self._tensors.values()))
            self._repeated = Repeated(self._decide, env.count) if env.is_one_launch else None
        self.diagnostics: dict[str, float] = {}
        """Scalars of the last update."""
        self._low, self._high = (torch.from_numpy(each).to(env.device) for each in (low, high))
        self._observations: Tensor | None = None
        self._rollout: Rollout | None = None
        self._k = torch.zeros(1, dtype=torch.int64, device=env.device)
        self._states = torch.zeros((env.n_rows, self._n_state), device=env.device)
        self._before = 0

    @property
    def _n_state(self) -> int:
        return self.policy.n_state if isinstance(self.policy, RecurrentActorCritic) else 0

    @property
    def robot_steps(self) -> int:
        """Control ticks of single robots so far."""
        return self._before + self.env.robot_steps

    @property
    def n_steps(self) -> int:
        """Decisions of each row in a rollout: fewer where there are many rows."""
        return min(self._hyperparameters.n_steps, max(MIN_STEPS, MAX_ROLLOUT // self.env.n_rows))

    def learn(self, robot_steps: int, seed: int | None = None) -> None:
        """Learn for at least `robot_steps`, in whole rollouts.

        A seed resets all worlds, and seeds them and torch; without one the worlds go on.
        """
        if seed is not None or self._observations is None:
            torch.manual_seed(seed or 0)
            self.env.seed(seed or 0)
            self._observations = self.env.reset()
            self._states.zero_()
        goal = self.robot_steps + robot_steps
        while self.robot_steps < goal:
            rollout, self._observations = self._roll_out(self._observations)
            self._update(rollout)

    def state(self) -> dict[str, Array]:
        """Parameters, Adam's moments and the number of robot-steps, by name."""
        named = self._tensors.items()
        arrays = {name: each.detach().cpu().numpy().copy() for name, each in named}
        return arrays | {"robot_steps": np.array(self.robot_steps)}

    @torch.no_grad()
    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Set what `state` returned; the next call of `learn` needs a seed to go on alike."""
        for name, each in self._tensors.items():
            each.copy_(torch.from_numpy(np.array(arrays[name])))
        self._before = int(arrays["robot_steps"]) - self.env.robot_steps

    @torch.no_grad()
    def _roll_out(self, observations: Tensor) -> tuple[Rollout, Tensor]:
        """Let all rows act for `n_steps` decisions; also return the observations after these.

        Both are overwritten by the next rollout.
        """
        rollout = self._rollout = self._rollout or self._empty_rollout(observations)
        rollout.observations[0], rollout.states[...] = observations, self._states
        self._k.zero_()
        self.policy.train(False)
        repeated = self._repeated
        with repeated.aside() if repeated else nullcontext():
            for _ in range(self.n_steps):
                (repeated or self._decide)()
            last = self._seen(rollout.observations[-1])
            rollout.values[-1] = self.policy.predict_values(last).flatten()
        self.env.check()
        return rollout, rollout.observations[-1]

    def _decide(self) -> None:
        """One decision of all rows, the k-th of the rollout; a graph repeats it.

        Episodes end by a time limit only, so the critic's value of the last observation replaces
        the rewards that would follow.
        """
        rollout, env, k = self._rollout, self.env, self._k
        assert rollout is not None
        seen = self._seen(rollout.observations.index_select(0, k)[0])
        actions, values, log_probs = self.policy(seen)
        rollout.acts.index_copy_(0, k, env.acts[None])
        take = env.launch if self._repeated else env.step
        step = take(torch.clamp(actions, self._low, self._high))
        if self._n_state:
            self._states = seen
        self._add_what_follows(step)
        rows = actions, log_probs, values.flatten(), step.rewards, step.ended.float()
        places = rollout.actions, rollout.log_probs, rollout.values, rollout.rewards, rollout.ends
        for there, here in zip(places, rows, strict=True):
            there.index_copy_(0, k, here[None])
        rollout.observations.index_copy_(0, k.add_(1), step.observations[None])

    def _add_what_follows(self, step: Step) -> None:
        """Add to the rewards of rows whose episodes end the discounted values of what they see.

        A GPU is asked for the values of all rows, as it would have to be waited for to know these.
        """
        is_gpu = self.env.device.type == "cuda"
        if is_gpu or step.ended.any():
            rows = slice(None) if is_gpu else step.ended
            last = self._seen(step.final_observations)[rows]
            values = self.policy.predict_values(last).flatten() * step.ended[rows]
            step.rewards[rows] += self._hyperparameters.discount * values
            self._states.masked_fill_(step.ended[:, None], 0.0)

    def _seen(self, observations: Tensor) -> Tensor:
        """What actor and critic see: observations, or of a memory the states after them."""
        if isinstance(self.policy, RecurrentActorCritic):
            return self.policy.next_states(observations, self._states)
        return observations

    def _empty_rollout(self, observations: Tensor) -> Rollout:
        n, n_rows = shape = self.n_steps, self.env.n_rows
        return Rollout(
            states=self._states.clone(),
            observations=observations.new_empty((n + 1, n_rows, observations.shape[1])),
            actions=observations.new_empty((*shape, len(self._low))),
            log_probs=observations.new_empty(shape),
            values=observations.new_empty((n + 1, n_rows)),
            rewards=observations.new_empty(shape),
            ends=observations.new_empty(shape),
            acts=observations.new_empty(shape, dtype=torch.bool),
        )

    def _update(self, rollout: Rollout) -> None:
        terms, policy = self._hyperparameters, self.policy
        gains = advantages(rollout, terms.discount, terms.gae_lambda)
        returns = (gains + rollout.values[:-1]).flatten()
        before, gains = rollout.log_probs.flatten(), gains.flatten()
        groups = self._groups(len(gains))
        why = "memory" if self._n_state else f"rows_together={terms.rows_together}"
        acts = _groups_that_act(rollout.acts, groups, why)
        n_minibatches = max(terms.n_minibatches, len(gains) // MIN_MINIBATCH)
        n_minibatches = min(n_minibatches, _n_acting(acts) // 2)
        observations, actions = rollout.observations[:-1], rollout.actions
        policy.train(True)
        for _ in range(terms.n_epochs):
            shuffled = torch.randperm(len(groups), device=gains.device)
            for acting, others in _minibatches(groups[shuffled], acts[shuffled], n_minibatches):
                rows = torch.cat((acting, others))
                batch = before[acting], gains[acting], returns[rows]
                if self._n_state:
                    losses = self._descend(*self._evaluate_sequences(rollout, rows), *batch)
                else:
                    seen, acted = (each.flatten(0, 1)[rows] for each in (observations, actions))
                    learn = self._learn_from if len(others) else self._learn
                    losses = learn(seen, acted, *batch)
        actor_loss, critic_loss, log_ratio = losses
        self.diagnostics = {
            "train/policy_gradient_loss": actor_loss.item(),
            "train/value_loss": critic_loss.item(),
            "train/std": torch.exp(policy.log_std).mean().item(),
            "train/reward": rollout.rewards.mean().item(),
            **policy_change(log_ratio),
        }

    def _groups(self, n: int) -> Tensor:
        """Numbers of decisions that share a minibatch: of one time, or of a row with a memory."""
        numbers = torch.arange(n, device=self.env.device)
        if self._n_state:
            return numbers.view(-1, self.env.n_rows).T
        return numbers.view(-1, self._hyperparameters.rows_together)

    def _learn_from(self, observations: Tensor, actions: Tensor, *batch: Tensor) -> Losses:
        """`_descend` on a minibatch of single decisions."""
        values, log_probs, _ = self.policy.evaluate_actions(observations, actions)
        return self._descend(values.flatten(), log_probs, *batch)

    def _evaluate_sequences(self, rollout: Rollout, numbers: Tensor) -> tuple[Tensor, Tensor]:
        """Values and log probabilities of numbered decisions, of a memory: of whole rows."""
        policy, n = self.policy, len(rollout.actions)
        assert isinstance(policy, RecurrentActorCritic)
        rows = numbers.view(-1, n)[:, 0]
        observations, states = rollout.observations[:-1, rows], rollout.states[rows]
        of_rows = observations, rollout.actions[:, rows], states, rollout.ends[:, rows]
        both = policy.evaluate_sequences(*of_rows)
        values, log_probs = (each.T.flatten() for each in both)
        return values, log_probs

    def _descend(
        self, values: Tensor, log_probs: Tensor, before: Tensor, gains: Tensor, returns: Tensor
    ) -> Losses:
        """Take a step of Adam along the clipped gradient of the loss of a minibatch.

        The first of its decisions are those whose actions count, with their log probabilities
        before the update and their advantages.
        """
        log_ratio = log_probs[: len(before)] - before
        actor_loss = clipped_loss(torch.exp(log_ratio), gains)
        critic_loss = torch.nn.functional.mse_loss(values, returns)
        self._optimizer.zero_grad()
        loss = actor_loss + VALUE_WEIGHT * critic_loss
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.policy.parameters(), MAX_GRADIENT_NORM)
        self._optimizer.step()
        return actor_loss.detach(), critic_loss.detach(), log_ratio.detach()
