"""PPO in tensors: policies, rollouts and updates stay on the device of the worlds.

A rollout consists of decisions of all rows. Its observations, actions and advantages form a table;
each epoch of the update takes the rows of the table in minibatches, in a new random order. On a GPU
a decision and an epoch of dense layers are a CUDA graph each; a CPU calls the same functions. Each
of several policies learns on an equal part of the rows.

The update is that of stable-baselines3, with its defaults for parameters that `PPOHyperparameters`
lacks; `tests/training/test_ppo_learner.py` compares the two.

Source: Schulman2017, Proximal Policy Optimization Algorithms.
"""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import cycle

import numpy as np
import torch
from torch import Tensor, nn

from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from training.actor_critic import ActorCritic, ActorCritics, RecurrentActorCritic, log_probs_of
from training.cuda_graphs import GraphedFunction, in_tf32
from training.tensor_vec_env import Step, TensorVecEnv

CLIP_RANGE = 0.2
"""Clipping range of the ratio of new to old probabilities, as in stable-baselines3."""

MAX_GRADIENT_NORM = 0.5
"""Largest norm of the gradient, which is clipped to it, as in stable-baselines3."""

EPSILON = 1e-5
"""Term added to Adam's denominator, as in stable-baselines3."""

MOMENTS = ("exp_avg", "exp_avg_sq")
"""Entries of Adam's state for each parameter, in addition to its number of steps."""


@dataclass(frozen=True)
class Rollout:
    """Transitions of a rollout; the first two axes are decisions and rows."""

    noise: Tensor
    """Standard normal noise of the actions, drawn before the first decision."""
    states: Tensor
    """Recurrent states before the first decision, (rows, state); empty without a memory."""
    observations: Tensor
    """Observations, with one decision more than actions."""
    actions: Tensor
    log_probs: Tensor
    values: Tensor
    """Values of the observations, with one decision more than actions."""
    rewards: Tensor
    """Rewards; at the end of an episode plus the discounted value of its last observation."""
    ends: Tensor
    """1 where an episode ends with the decision, else 0."""
    acts: Tensor
    """True where the action counts."""


def advantages(rollout: Rollout, discount: float, gae_lambda: float) -> Tensor:
    """Return generalised advantage estimates, shape (decisions, rows).

        delta_t = r_t + discount v_{t+1} - v_t
        A_t     = delta_t + discount lambda A_{t+1}

    where v_{t+1} and A_{t+1} are 0 if an episode ends at t. If the action at t + 1 does not count,
    lambda is 1: an action is credited with all rewards until the next action that counts, and only
    there a value replaces later rewards. Sums over 1, 2, 4 ... decisions are computed from sums
    over half as many, for all decisions at once.

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


def clipped_loss(ratio: Tensor, gains: Tensor) -> tuple[Tensor, Tensor]:
    """Return the clipped surrogate losses of minibatches, a row each, and their gradients.

        L       = - mean min(r A, clip(r) A)
        dL/dlnr = - r A / n   where r A is the smaller one, else 0

    r is the ratio of new to old probability of each action, A its normalised advantage.

    Source: Schulman2017, Eq. 7.
    """
    deviation, mean = torch.std_mean(gains, 1, keepdim=True)
    normal = (gains - mean) / (deviation + 1e-8)
    terms = ratio * normal
    least = torch.minimum(terms, torch.clamp(ratio, 1.0 - CLIP_RANGE, 1.0 + CLIP_RANGE) * normal)
    return -least.mean(1), terms.masked_fill(terms > least, 0.0) / -gains.shape[1]


VALUE_WEIGHT = 0.5
"""Weight of the critic's loss, as in stable-baselines3."""

MAX_ROLLOUT, MIN_MINIBATCH = 2**20, 2**15
"""Approximate largest number of decisions in a policy's rollout, and least number in a minibatch
of rollouts that are large enough for more than `n_minibatches` of them."""

MIN_STEPS = 16
"""Least number of decisions of each row in a rollout."""


@dataclass(frozen=True)
class PPOHyperparameters:
    """Hyperparameters of PPO; stable-baselines3's defaults but for rollout, batches and rate."""

    discount: float = 0.99
    """Discount factor of one decision."""
    gae_lambda: float = 0.95
    """Lambda of generalised advantage estimation."""
    n_steps: int = 128
    """Largest number of decisions of each robot in one rollout."""
    n_minibatches: int = 20
    """Least number of minibatches per rollout and epoch."""
    n_epochs: int = 10
    learning_rate: float = 7e-4
    rows_together: int = 1
    """Rows of a decision that share a minibatch: the robots of a world, if a network spans them."""


class ClippedAdam:
    """Adam for networks of several policies; the gradient of each policy is clipped as a whole.

    Each parameter consists of equal parts, one for each policy in turn. On a GPU, steps can be part
    of a CUDA graph.
    """

    def __init__(self, networks: nn.Module, n_policies: int, rate: float) -> None:
        self._parameters, self._n_policies = list(networks.parameters()), n_policies
        device = self._parameters[0].device
        on_gpu = device.type == "cuda"
        usable = torch.tensor(rate, device=device) if on_gpu else rate
        self._adam = torch.optim.Adam(
            self._parameters, usable, eps=EPSILON, fused=on_gpu or None, capturable=on_gpu
        )
        self.steps = [torch.zeros((), device=device) for _ in self._parameters]
        """Number of steps taken, for each parameter."""
        self.tensors: dict[str, Sequence[Tensor]] = {"policy": self._parameters}
        """Lists of tensors, one for each parameter, by name: the parameters and both moments."""
        for name in MOMENTS:
            self.tensors[name] = [torch.zeros_like(each) for each in self._parameters]
        columns = zip(self.steps, *self.tensors.values(), strict=True)
        for step, parameter, *moments in columns:
            named = dict(zip(MOMENTS, moments, strict=True))
            self._adam.state[parameter] = {"step": step, **named}

    def descend(self, outputs: Sequence[Tensor], along: Sequence[Tensor]) -> None:
        """Take a step along gradients of losses with respect to outputs of the networks."""
        gradients = torch.autograd.grad(outputs, self._parameters, along)
        of_policies = [each.reshape(self._n_policies, -1) for each in gradients]
        norms = torch.cat(of_policies, 1).norm(dim=1, keepdim=True)
        scale = torch.clamp(MAX_GRADIENT_NORM / (norms + 1e-6), max=1.0)
        for parameter, gradient in zip(self._parameters, of_policies, strict=True):
            parameter.grad = (gradient * scale).view_as(parameter)
        self._adam.step()


Losses = tuple[Tensor, ...]
"""Losses of actors and of critics, and logarithms of the ratios of new to old probabilities."""


def _diagnostics(losses: Losses, rewards: Tensor, log_std: Tensor) -> list[dict[str, float]]:
    """Return scalars of the last update of each policy."""
    actor_loss, critic_loss, log_ratio = losses
    ratio = torch.exp(log_ratio)
    columns = {
        "train/policy_gradient_loss": actor_loss,
        "train/value_loss": critic_loss,
        "train/std": torch.exp(log_std).mean(1),
        "train/reward": rewards.mean((0, 2)),
        "train/approx_kl": (ratio - 1.0 - log_ratio).mean(1),
        "train/clip_fraction": ((ratio - 1.0).abs() > CLIP_RANGE).float().mean(1),
    }
    numbers = torch.stack([*columns.values()], 1).tolist()
    return [dict(zip(columns, each, strict=True)) for each in numbers]


class PPOLearner:
    """PPO on the rows of an environment, with parameter sharing: one policy for all.

        env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=1024, physics="kinematic")])
        policy = ActorCritic(len(env.observation_layout), *env.action_space.shape)
        learner = PPOLearner(env, policy, PPOHyperparameters())
        learner.learn(10**7, seed=0)

    Each of several policies learns on an equal part of the worlds, as it would alone.
    """

    def __init__(
        self,
        env: TensorVecEnv,
        policy: ActorCritic | Sequence[ActorCritic],
        hyperparameters: PPOHyperparameters,
    ) -> None:
        """Move the policies to the environment's device. ConfigError if they do not fit it."""
        self._low, self._high = env.action_bounds
        policies = policy if isinstance(policy, Sequence) else [policy]
        env.check_shares(len(policies), hyperparameters.rows_together)
        self.env, self._hyperparameters, device = env, hyperparameters, env.device
        self.policies = [each.to(device) for each in policies]
        self.policy = self.policies[0]
        if self.policy.n_state and hyperparameters.rows_together > 1:
            raise ConfigError(
                f"rows_together={hyperparameters.rows_together}: a network with memory is"
                " trained on whole rows, one by one; leave it out"
            )
        is_dense = len(policies) > 1 or ActorCritics.fits(policies)
        self._networks = ActorCritics(policies) if is_dense else self.policy
        self._adam = ClippedAdam(self._networks, len(policies), hyperparameters.learning_rate)
        self._repeated: GraphedFunction[None] | None = None
        self._repeated_epoch: GraphedFunction[Losses] | None = None
        if device.type == "cuda" and type(self.policy) in (ActorCritic, RecurrentActorCritic):
            self._repeated_epoch = GraphedFunction(self._epoch)
            self._repeated = GraphedFunction(self._decide, env.count) if env.is_one_launch else None
        self.diagnostics: dict[str, float] = {}
        """Scalars of the last update of the first policy; `all_diagnostics` are of each policy."""
        self.all_diagnostics = [self.diagnostics]
        self._generators = [torch.Generator(device) for _ in policies]
        self._observations: Tensor | None = None
        self._k = torch.zeros(1, dtype=torch.int64, device=device)
        self._states = torch.zeros((env.n_rows, self.policy.n_state), device=device)
        self._rollout, self._before = self._empty_rollout(), 0

    @property
    def robot_steps(self) -> int:
        """Robot-steps (control ticks of single robots) so far, per policy."""
        return self._before + self.env.robot_steps // len(self.policies)

    @property
    def n_steps(self) -> int:
        """Number of decisions of each row in a rollout, which falls with the rows of a policy."""
        n_rows = self.env.n_rows // len(self.policies)
        return min(self._hyperparameters.n_steps, max(MIN_STEPS, MAX_ROLLOUT // n_rows))

    def learn(self, robot_steps: int, seed: int | Sequence[int] | None = None) -> None:
        """Train for at least `robot_steps` per policy, in whole rollouts.

        A seed resets all worlds and seeds worlds, actions and minibatches; without a seed the
        worlds go on. Each policy has its own seed; from a single seed they count up.
        """
        if seed is not None or self._observations is None:
            first, n = seed or 0, len(self.policies)
            seeds = first if isinstance(first, Sequence) else range(first, first + n)
            for generator, own_seed in zip(self._generators, seeds, strict=True):
                generator.manual_seed(own_seed)
            self.env.seed(*seeds)
            self._observations = self.env.reset()
            self._states.zero_()
        goal = self.robot_steps + robot_steps
        with in_tf32() if self.env.device.type == "cuda" else nullcontext():
            while self.robot_steps < goal:
                rollout, self._observations = self._roll_out(self._observations)
                self._update(rollout)

    def state(self, policy: int = 0) -> dict[str, Array]:
        """Return a policy's parameters, Adam's state and the number of robot-steps, by name."""
        tensors = self._tensors_of(policy)
        arrays = {name: each.numpy(force=True).copy() for name, each in tensors.items()}
        return arrays | {"robot_steps": np.array(self.robot_steps)}

    @torch.no_grad()
    def restore(self, arrays: Mapping[str, Array], policy: int = 0) -> None:
        """Restore the arrays of `state`; to repeat a training, pass a seed to the next `learn`."""
        for name, each in self._tensors_of(policy).items():
            each.copy_(torch.from_numpy(np.array(arrays[name])))
        self._before = int(arrays["robot_steps"]) - self.env.robot_steps // len(self.policies)

    def _tensors_of(self, policy: int) -> dict[str, Tensor]:
        """Return the tensors that an update changes: parameters, and Adam's state for each."""
        named = {
            f"{kind}.{name}": each
            for kind, tensors in self._adam.tensors.items()
            for name, each in self._networks.named(policy, tensors).items()
        }
        names = (f"step.{name}" for name, _ in self.policy.named_parameters())
        return named | dict(zip(names, cycle(self._adam.steps)))

    @torch.no_grad()
    def _roll_out(self, observations: Tensor) -> tuple[Rollout, Tensor]:
        """Let all rows act; return the rollout and the last observations, until the next call."""
        rollout = self._rollout
        rollout.observations[0], rollout.states[...] = observations, self._states
        parts = rollout.noise.tensor_split(len(self.policies), 1)
        for part, generator in zip(parts, self._generators, strict=True):
            part.copy_(torch.randn(part.shape, generator=generator, device=part.device))
        self._k.zero_()
        repeated = self._repeated
        with repeated.in_stream() if repeated else nullcontext():
            for _ in range(self.n_steps):
                (repeated or self._decide)()
            rollout.values[-1] = self._values(rollout.observations[-1])
        self.env.check()
        return rollout, rollout.observations[-1]

    def _decide(self) -> None:
        """Run decision k of the rollout for all rows; a CUDA graph can repeat it.

        Episodes end by a time limit only, so the critic's value of the last observation replaces
        the rewards that would follow.
        """
        rollout, env, k = self._rollout, self.env, self._k
        observations = rollout.observations.index_select(0, k)[0]
        encoded = self.policy.next_states(observations, self._states)
        mean, log_std, values = self._outputs(encoded)
        drawn = mean + log_std.exp() * rollout.noise.index_select(0, k).view_as(mean)
        actions, log_probs = drawn.flatten(0, 1), log_probs_of(drawn, mean, log_std)
        rollout.acts.index_copy_(0, k, env.acts[None])
        clamped = torch.clamp(actions, self._low, self._high)
        step = env.launch(clamped) if self._repeated else env.step(clamped)
        if self.policy.n_state:
            self._states.copy_(encoded)
        rewards = step.rewards + self._bootstrap(step)
        rows = actions, log_probs.flatten(), values.flatten(), rewards, step.ended.float()
        places = rollout.actions, rollout.log_probs, rollout.values, rollout.rewards, rollout.ends
        for there, here in zip(places, rows, strict=True):
            there.index_copy_(0, k, here[None])
        rollout.observations.index_copy_(0, k.add_(1), step.observations[None])

    def _bootstrap(self, step: Step) -> Tensor | float:
        """Return discounted values of last observations where episodes end, and reset states there.

        On a GPU the values are always computed: a test whether episodes end would wait for the GPU.
        """
        if self.env.device.type != "cuda" and not step.ended.any():
            return 0.0
        values = self._values(step.final_observations)
        self._states.masked_fill_(step.ended[:, None], 0.0)
        return self._hyperparameters.discount * values * step.ended

    def _values(self, observations: Tensor) -> Tensor:
        encoded = self.policy.next_states(observations, self._states)
        return self._outputs(encoded)[-1].flatten()

    def _outputs(self, encoded: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return mean actions, log standard deviations and values, policies by their rows."""
        return self._networks.outputs(encoded.view(len(self.policies), -1, encoded.shape[1]))

    def _empty_rollout(self) -> Rollout:
        n, n_rows, n_actions = self.n_steps, self.env.n_rows, len(self._low)
        n_observed, new = len(self.env.observation_layout), self._low.new_empty
        self._columns = [n_observed, n_actions, 3]
        self._table = new((n, n_rows, sum(self._columns)))
        of_actions, numbers, more = (n, n_rows, n_actions), (n, n_rows), (n + 1, n_rows)
        return Rollout(
            noise=new(of_actions), states=self._states.clone(), actions=new(of_actions),
            observations=new((*more, n_observed)), log_probs=new(numbers), values=new(more),
            rewards=new(numbers), ends=new(numbers), acts=new(numbers, dtype=torch.bool),
        )  # fmt: skip

    def _update(self, rollout: Rollout) -> None:
        """Run all epochs on a rollout, whose decisions become the rows of the table."""
        terms = self._hyperparameters
        gains = advantages(rollout, terms.discount, terms.gae_lambda)
        returns = gains + rollout.values[:-1]
        scalars = torch.stack((rollout.log_probs, gains, returns), -1)
        columns = rollout.observations[:-1], rollout.actions, scalars
        torch.cat(columns, -1, out=self._table)
        groups = self._groups(rollout.acts)
        for _ in range(terms.n_epochs):
            losses = self._take_epoch(*groups)
        log_std = torch.stack([each.log_std.detach() for each in self.policies])
        rewards = rollout.rewards.view(len(gains), len(self.policies), -1)
        self.all_diagnostics = _diagnostics(losses, rewards, log_std)
        self.diagnostics = self.all_diagnostics[0]

    def _groups(self, acts: Tensor) -> tuple[Tensor, Tensor | None]:
        """Return indices of decisions, policies by groups by decisions, and which groups count.

        A group is of one time or, with a memory, of one row. No second tensor: all groups count.
        """
        numbers = torch.arange(acts.numel(), device=acts.device)
        groups = numbers.view(len(acts), len(self.policies), -1).permute(1, 2, 0)
        if not self.policy.n_state:
            groups = groups.mT.reshape(len(groups), -1, self._hyperparameters.rows_together)
        counts, n_acting = acts.flatten()[groups].all(2), int(acts.sum())
        if int(counts.sum()) * groups.shape[2] != n_acting:
            raise ConfigError(
                "step_on='exchange': rows that go together must act in the same steps; use a"
                " network without memory, and rows_together=1"
            )
        if n_acting < 2:
            raise ConfigError(
                f"step_on='exchange': {n_acting} exchanges in a rollout, which is too few to"
                " learn from; use more robots or worlds"
            )
        return groups, None if n_acting == acts.numel() else counts

    def _take_epoch(self, groups: Tensor, counts: Tensor | None) -> Losses:
        """Run an epoch on groups of decisions, which are shuffled for each policy."""
        n, device = groups.shape[1], groups.device
        drawn = [torch.randperm(n, generator=each, device=device) for each in self._generators]
        order = torch.stack(drawn)
        shuffled = groups.gather(1, order[..., None].expand_as(groups))
        if counts is not None:
            acts = counts.gather(1, order)
            return self._epoch(shuffled[acts][None], shuffled[~acts][None])
        repeated = self._repeated_epoch
        with repeated.in_stream() if repeated else nullcontext():
            return (repeated or self._epoch)(shuffled, shuffled[:, :0])

    def _epoch(self, acting: Tensor, others: Tensor) -> Losses:
        """Take a step for each minibatch of groups whose actions count (`acting`) and others."""
        n = (acting[0].numel() + others[0].numel()) // MIN_MINIBATCH
        n = min(max(self._hyperparameters.n_minibatches, n), max(acting.shape[1] // 2, 1))
        parts = ([x.flatten(1) for x in some.tensor_split(n, 1)] for some in (acting, others))
        for minibatch in zip(*parts, strict=True):
            losses = self._descend(*minibatch)
        return losses

    def _descend(self, acting: Tensor, others: Tensor) -> Losses:
        """Take a step of Adam along the gradients of the losses of a minibatch.

        The arguments are indices of decisions, a row per policy: those whose actions count, and the
        others, from which only the critic learns.
        """
        rows, n = torch.cat((acting, others), 1), acting.shape[1]
        encoded, actions, scalars = torch.split(self._table.flatten(0, 1)[rows], self._columns, -1)
        if self.policy.n_state:  # groups are whole rows
            rollout, of = self._rollout, rows.view(-1, self.n_steps)[:, 0]
            observations, states = rollout.observations[:-1, of], rollout.states[of]
            after = self.policy.states(observations, states, rollout.ends[:, of])
            encoded = after.transpose(0, 1).reshape(1, rows.numel(), -1)
        mean, log_std, values = self._networks.outputs(encoded)
        before, gains, returns = scalars.unbind(-1)
        log_probs = log_probs_of(actions, mean, log_std)[:, :n]
        log_ratio, errors = (log_probs - before[:, :n]).detach(), (values - returns).detach()
        actor_loss, slopes = clipped_loss(torch.exp(log_ratio), gains[:, :n])
        along = slopes, errors * (2.0 * VALUE_WEIGHT / errors.shape[1])
        self._adam.descend((log_probs, values), along)
        return actor_loss, errors.square().mean(1), log_ratio
