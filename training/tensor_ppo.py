"""PPO in tensors that stay where the worlds are: policy, rollouts and updates on one device.

The updates are those of stable-baselines3, whose rollouts are NumPy, with its defaults for what
`PPOHyperparameters` does not name; so is the policy. What differs is the order of the rows in
minibatches, and that worlds go on from one call of `learn` to the next.

Source: Schulman2017, Proximal Policy Optimization Algorithms.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.utils import set_random_seed
from torch import Tensor

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.device_env import array_env
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.observed_fields import FieldLayout
from training.actor_critic import LayerActorCriticPolicy
from training.experiment import Experiment, worlds_per_scenario
from training.sb3_setup import PPOHyperparameters, env_options
from training.tensor_rows import TensorRows

CLIP_RANGE, VALUE_WEIGHT, MOST_GRADIENT = 0.2, 0.5, 0.5
"""Clipping of the ratio, weight of the critic's loss, largest norm of a gradient: as SB3."""

ROLLOUT, MINIBATCH = 2**20, 2**15
"""Decisions of a rollout, at most about, and of a minibatch, at least, unless a rollout has less
than its number of minibatches of them. Chosen without a GPU at hand."""

FEWEST_STEPS = 16
"""Decisions of each row in a rollout, at least."""


@dataclass(frozen=True)
class Rollout:
    """What happened in a rollout, decisions by rows; after the last a value for each row."""

    seen: Tensor
    actions: Tensor
    log_probs: Tensor
    values: Tensor
    rewards: Tensor
    begins: Tensor
    """1 where a row is at the begin of an episode, else 0; one decision more than the others."""


class TensorPPO:
    """PPO on the rows of blocks of worlds, with parameter sharing: one policy for all.

    rows = TensorRows([array_env("es1", device="cuda", n_worlds=1024, physics="kinematic")])
    policy = ActorCriticPolicy(rows.observation_space, rows.action_space, lambda _: 3e-4)
    ppo = TensorPPO(rows, policy, PPOHyperparameters(decision_period=10))
    ppo.learn(10**6, 3e-4, seed=0)
    """

    def __init__(
        self, rows: TensorRows, policy: ActorCriticPolicy, hyperparameters: PPOHyperparameters
    ) -> None:
        """Bring a policy of stable-baselines3 to the device of the rows, to be trained there.

        Of the hyperparameters those of the learner count; those of the environment are the rows'.
        """
        if not isinstance(rows.action_space, Box):
            raise ConfigError("discrete: PPO in tensors gives numbers, not choices; leave it out")
        self.rows, self._hyperparameters = rows, hyperparameters
        self.policy = policy.to(rows.device)
        self.num_timesteps = 0
        self.told: dict[str, float] = {}
        """What is told of the last update, by name."""
        self._low = torch.from_numpy(rows.action_space.low).to(rows.device)
        self._high = torch.from_numpy(rows.action_space.high).to(rows.device)
        self._seen: Tensor | None = None
        self._begins = torch.ones(rows.n_rows, device=rows.device)

    @property
    def n_steps(self) -> int:
        """Decisions of each row in a rollout: fewer where there are many rows."""
        most = max(FEWEST_STEPS, ROLLOUT // self.n_rows)
        return min(self._hyperparameters.n_steps, most)

    @property
    def observation_layout(self) -> FieldLayout:
        """What a row of an observation is made of."""
        return self.rows.observation_layout

    @property
    def n_rows(self) -> int:
        """Robots that learn, in all worlds."""
        return self.rows.n_rows

    @property
    def stepping_s(self) -> float:
        """Wall time of all steps of the worlds [s]."""
        return self.rows.stepping_s

    def worlds_state(self) -> dict[str, Array]:
        """What the rows, on a GPU, go on from after `learn`, by name."""
        seen = self._seen
        shape = self.n_rows, len(self.observation_layout)
        return {
            "has_begun": np.array(seen is not None),
            "seen": np.zeros(shape, np.float32) if seen is None else seen.numpy(force=True),
            "begins": self._begins.numpy(force=True),
            **self.rows.records(),
        }

    def restore_worlds(self, state: Mapping[str, Array]) -> None:
        """Let the rows go on as when `worlds_state` told this."""
        if not state["has_begun"]:
            return
        device = self.rows.device
        self._seen = torch.from_numpy(np.array(state["seen"])).to(device)
        self._begins = torch.from_numpy(np.array(state["begins"])).to(device)
        self.rows.take_records(state)

    def learn(self, decisions: int, learning_rate: float, seed: int) -> None:
        """Learn from so many decisions of single rows, at least, in whole rollouts.

        `seed` seeds all generators, and where worlds have not begun theirs too.
        """
        set_random_seed(seed)
        if self._seen is None:
            self.rows.seed(seed)
            self._seen = self.rows.reset()
        for group in self.policy.optimizer.param_groups:
            group["lr"] = learning_rate
        goal = self.num_timesteps + decisions
        while self.num_timesteps < goal:
            self._update(self._rollout(self._seen))

    @torch.no_grad()
    def _rollout(self, seen: Tensor) -> Rollout:
        """Let all rows act for `n_steps` decisions.

        An episode ends by its time only, and the world goes on: what would follow is added to the
        last reward, by the critic.
        """
        n, rows, discount = self.n_steps, self.rows, self._hyperparameters.discount
        shape = n, rows.n_rows
        kept = Rollout(
            seen.new_empty((*shape, seen.shape[1])),
            seen.new_empty((*shape, len(self._low))),
            seen.new_empty(shape),
            seen.new_empty((n + 1, rows.n_rows)),
            seen.new_empty(shape),
            seen.new_zeros((n + 1, rows.n_rows)),
        )
        self.policy.set_training_mode(False)
        kept.begins[0] = self._begins
        for k in range(n):
            actions, values, log_probs = self.policy(seen)
            step = rows.step(torch.clamp(actions, self._low, self._high))
            kept.seen[k], kept.actions[k], kept.log_probs[k] = seen, actions, log_probs
            kept.values[k], kept.rewards[k] = values.flatten(), step.rewards
            if len(step.over):
                after = self.policy.predict_values(step.final[step.over]).flatten()
                kept.rewards[k, step.over] += discount * after
                kept.begins[k + 1, step.over] = 1.0
            seen = step.seen
        kept.values[n] = self.policy.predict_values(seen).flatten()
        self._seen, self._begins = seen, kept.begins[n]
        self.num_timesteps += n * rows.n_rows
        return kept

    def _update(self, rollout: Rollout) -> None:
        """Adapt policy and critic to a rollout."""
        terms, policy = self._hyperparameters, self.policy
        gained = advantages(rollout, terms.discount, terms.gae_lambda)
        returns = (gained + rollout.values[:-1]).flatten()
        seen, actions = rollout.seen.flatten(0, 1), rollout.actions.flatten(0, 1)
        before, gained = rollout.log_probs.flatten(), gained.flatten()
        n_minibatches = max(terms.n_minibatches, len(gained) // MINIBATCH)
        policy.set_training_mode(True)
        for _ in range(terms.n_epochs):
            shuffled = torch.randperm(len(gained), device=gained.device)
            for chosen in shuffled.tensor_split(n_minibatches):
                values, log_probs, _ = policy.evaluate_actions(seen[chosen], actions[chosen])
                ratio = torch.exp(log_probs - before[chosen])
                actor_loss = clipped_loss(ratio, gained[chosen])
                critic_loss = torch.nn.functional.mse_loss(returns[chosen], values.flatten())
                policy.optimizer.zero_grad()
                loss = actor_loss + VALUE_WEIGHT * critic_loss
                loss.backward()  # type: ignore[no-untyped-call]
                torch.nn.utils.clip_grad_norm_(policy.parameters(), MOST_GRADIENT)
                policy.optimizer.step()
        self.told = {
            "train/policy_gradient_loss": actor_loss.item(),
            "train/value_loss": critic_loss.item(),
            "train/std": torch.exp(policy.log_std).mean().item(),
            "train/reward": rollout.rewards.mean().item(),
        }


def advantages(rollout: Rollout, discount: float, gae_lambda: float) -> Tensor:
    """Generalised advantage estimates, decisions by rows.

        delta_t = r_t + discount v_{t+1} - v_t
        A_t     = delta_t + discount lambda A_{t+1}

    where v_{t+1} and A_{t+1} are 0 if an episode begins then.

    Source: Schulman2016, Eq. 16.
    """
    found = torch.empty_like(rollout.rewards)
    last = torch.zeros_like(rollout.rewards[0])
    for k in reversed(range(len(found))):
        goes_on = 1.0 - rollout.begins[k + 1]
        gained = discount * goes_on * rollout.values[k + 1] - rollout.values[k]
        last = rollout.rewards[k] + gained + discount * gae_lambda * goes_on * last
        found[k] = last
    return found


def clipped_loss(ratio: Tensor, gained: Tensor) -> Tensor:
    """The clipped surrogate loss of a minibatch, whose advantages are normalised.

    Source: Schulman2017, Eq. 7.
    """
    normal = (gained - gained.mean()) / (gained.std() + 1e-8)
    clipped = torch.clamp(ratio, 1.0 - CLIP_RANGE, 1.0 + CLIP_RANGE)
    return -torch.min(normal * ratio, normal * clipped).mean()


def make_tensor_ppo(experiment: Experiment, hyperparameters: PPOHyperparameters) -> TensorPPO:
    """Make PPO for an experiment on its device; the first episodes end one after the other.

    Its seed seeds all generators of this process.
    """
    scenarios = experiment.scenarios_by_name
    blocks = [
        array_env(
            scenarios[name],
            device=experiment.device,
            n_worlds=n_worlds,
            stagger=True,
            **env_options(experiment, hyperparameters),
        )
        for name, n_worlds in worlds_per_scenario(experiment).items()
    ]
    set_random_seed(experiment.seed)
    rows = TensorRows(blocks)
    policy = LayerActorCriticPolicy(
        rows.observation_space,
        rows.action_space,
        lambda _: hyperparameters.learning_rate,
        layout=rows.observation_layout,
        layers=experiment.layers,
        log_std_init=hyperparameters.log_std,
    )
    return TensorPPO(rows, policy, hyperparameters)
