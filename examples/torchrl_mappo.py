"""TorchRL: one policy for all robots, learned from scratch by PPO with a critic of the truth.

    make .venv-torchrl/.ready            # the tested set, with torchrl beside
    .venv-torchrl/bin/python examples/torchrl_mappo.py

The critic reads "state": true poses and all beliefs, which no robot ever sees (MAPPO); with
`--ippo` it reads what the policy reads. At the end the policy is scored without its noise and with
it, beside random actions. Five robots between near areas take some minutes; `--scenario es1` is the
world of the papers.
"""

import argparse
import time
from collections.abc import Sequence
from typing import Any

import torch
from tensordict import TensorDictBase
from tensordict.nn import TensorDictModule
from torch import Tensor, nn
from torchrl.collectors import Collector
from torchrl.envs import RewardSum, TransformedEnv
from torchrl.envs.utils import ExplorationType, set_exploration_type
from torchrl.modules import MultiAgentMLP, NormalParamExtractor, ProbabilisticActor, TanhNormal
from torchrl.objectives import ClipPPOLoss, ValueEstimators

import baselines.controllers  # noqa: F401 runs the layers that are not learned
from training.torchrl_env import SwarmTorchEnv

DISCOUNT = 0.995
"""Of a decision, which is held for five ticks of 0.1 s."""

TERMS = {
    "learn": "motion",
    "decision_period": 5,
    "shaping": 1.0,
    "discount": DISCOUNT,
}
"""Keywords of `parallel_env` for both scenarios."""

SCENARIOS: dict[str, dict[str, Any]] = {
    "near": {
        "scenario": "es1",
        "task.n_robots": 5,
        "task.area_distance": 0.7,
        "task.duration": 300.0,
        "sensors.wheel_noise": 0.0,
    },
    "es1": {"scenario": "es1"},
}
"""Few robots that know where they are, near areas, five minutes; and the world of the papers."""

GROUP = "epuck"
OBSERVATION, ACTION, VALUE = (GROUP, "observation"), (GROUP, "action"), (GROUP, "state_value")
REWARD, RETURN = (GROUP, "reward"), (GROUP, "episode_reward")
N_WORLDS = 16
LEARNING_RATE = 1e-3


def make_env(seed: int, **options: Any) -> TransformedEnv:
    """Worlds whose episodes end one after the other; the rewards of an episode are summed up."""
    env = SwarmTorchEnv(n_worlds=N_WORLDS, seed=seed, stagger=True, **options)
    return TransformedEnv(env, RewardSum(in_keys=[REWARD], out_keys=[RETURN]))


def network(n_in: int, n_out: int, n_robots: int) -> MultiAgentMLP:
    """Two layers of 64, the same weights for every robot, each from its own numbers."""
    return MultiAgentMLP(
        n_agent_inputs=n_in,
        n_agent_outputs=n_out,
        n_agents=n_robots,
        centralized=False,  # codespell:ignore centralized
        share_params=True,
        depth=2,
        num_cells=64,
        activation_class=nn.Tanh,
    )


class WithState(nn.Module):
    """A network that is shown the true state beside each robot's observation."""

    def __init__(self, net: nn.Module) -> None:
        super().__init__()
        self.net = net

    def forward(self, observation: Tensor, state: Tensor) -> Tensor:
        """The same state for all robots of a world."""
        state = state[..., None, :].expand(*observation.shape[:-1], -1)
        return self.net(torch.cat([observation, state], -1))


def make_policy(env: TransformedEnv) -> ProbabilisticActor:
    """A squashed Gaussian over actions, from a robot's own observation."""
    n_robots, n_observed = env.observation_spec[OBSERVATION].shape[1:]
    space = env.full_action_spec_unbatched[ACTION].space
    net = network(n_observed, 2 * space.low.shape[-1], n_robots)
    parameters = [(GROUP, "loc"), (GROUP, "scale")]
    return ProbabilisticActor(
        TensorDictModule(
            nn.Sequential(net, NormalParamExtractor()), in_keys=[OBSERVATION], out_keys=parameters
        ),
        spec=env.full_action_spec_unbatched,
        in_keys=parameters,
        out_keys=[ACTION],
        distribution_class=TanhNormal,
        distribution_kwargs={"low": space.low, "high": space.high},
        return_log_prob=True,
    )


def make_critic(env: TransformedEnv, is_ippo: bool = False) -> TensorDictModule:
    """One value for each robot, from its own observation alone (IPPO), or with the state."""
    n_robots, n_observed = env.observation_spec[OBSERVATION].shape[1:]
    if is_ippo:
        return TensorDictModule(network(n_observed, 1, n_robots), [OBSERVATION], [VALUE])
    n_in = n_observed + env.observation_spec["state"].shape[-1]
    net = WithState(network(n_in, 1, n_robots))
    return TensorDictModule(net, [OBSERVATION, "state"], [VALUE])


def make_loss(policy: ProbabilisticActor, critic: TensorDictModule) -> ClipPPOLoss:
    """Clipped PPO with GAE; a time-out is bootstrapped, as only "terminated" counts as an end."""
    loss = ClipPPOLoss(
        policy,
        critic,
        clip_epsilon=0.2,
        entropy_coeff=0.0,
        normalize_advantage=True,
        normalize_advantage_exclude_dims=(-1,),  # one scale for all robots; the last axis is of 1
    )
    loss.set_keys(
        action=ACTION,
        value=VALUE,
        reward=REWARD,
        done=(GROUP, "done"),
        terminated=(GROUP, "terminated"),
    )
    loss.make_value_estimator(ValueEstimators.GAE, gamma=DISCOUNT, lmbda=0.95)
    return loss


def learn(loss: ClipPPOLoss, optimiser: torch.optim.Optimizer, seen: TensorDictBase) -> None:
    """Four times over what was seen, in eight parts each."""
    for _ in range(4):
        with torch.no_grad():
            loss.value_estimator(seen)
        frames = seen.reshape(-1)
        for part in frames[torch.randperm(len(frames))].split(max(len(frames) // 8, 1)):
            losses = loss(part)
            total = losses["loss_objective"] + losses["loss_critic"] + losses["loss_entropy"]
            optimiser.zero_grad()
            total.backward()
            nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
            optimiser.step()


def train(
    iterations: int, seed: int = 1, steps: int = 128, is_ippo: bool = False, **options: Any
) -> ProbabilisticActor:
    """Train the policy on `steps` decisions of each world in an iteration."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)  # quicker for networks this small
    env = make_env(seed, **options)
    policy = make_policy(env)
    loss = make_loss(policy, make_critic(env, is_ippo))
    optimiser = torch.optim.Adam(loss.parameters(), lr=LEARNING_RATE)
    frames = steps * N_WORLDS
    collector = Collector(env, policy, frames_per_batch=frames, total_frames=iterations * frames)
    begun = time.perf_counter()
    for iteration, seen in enumerate(collector, start=1):
        learn(loss, optimiser, seen)
        over = seen["next", "done"].squeeze(-1)
        if over.any():
            trips = seen["next", GROUP, "info", "round_trips"][over].sum(-1).mean()
            mean_return = seen["next", *RETURN][over].mean()
            print(
                f"iteration {iteration}, {time.perf_counter() - begun:.0f} s:"
                f" {trips:.1f} round trips, return {mean_return:.2f}",
                flush=True,
            )
    collector.shutdown()
    return policy


def round_trips(
    policy: ProbabilisticActor | None, seed: int = 1000, stochastic: bool = False, **options: Any
) -> float:
    """Mean over an episode in each world, of the policy, stochastic or not, or at random."""
    env = SwarmTorchEnv(n_worlds=N_WORLDS, seed=seed, **options)
    how = ExplorationType.RANDOM if stochastic else ExplorationType.DETERMINISTIC
    with torch.no_grad(), set_exploration_type(how):
        seen = env.rollout(env.max_cycles, policy)
    return float(seen[:, -1]["next", GROUP, "info", "round_trips"].sum(-1).mean())


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line, train, and compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--scenario", choices=sorted(SCENARIOS), default="near")
    parser.add_argument("--ippo", action="store_true", help="no state for the critic")
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    options = {**TERMS, **SCENARIOS[chosen.scenario]}
    policy = train(chosen.iterations, chosen.seed, is_ippo=chosen.ippo, **options)
    print(f"learned: {round_trips(policy, **options):.1f} round trips an episode")
    print(f"the same, stochastic: {round_trips(policy, stochastic=True, **options):.1f}")
    print(f"random: {round_trips(None, **options):.1f}")


if __name__ == "__main__":
    main()
