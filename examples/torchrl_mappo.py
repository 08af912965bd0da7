"""TorchRL: `PettingZooWrapper`, one policy for all robots, a critic that knows the truth (MAPPO).

    make .venv-torchrl/.ready            # the tested set, with torchrl beside
    .venv-torchrl/bin/python examples/torchrl_mappo.py --scenario es1 --learn weighting

The critic reads `env.state()`: true poses and all beliefs, which no robot ever sees.

A weighting is learned while hand-written motion brings in the round trips. A motion must first find
the areas, which wheel speeds drawn around zero never do: see `cleanrl_ppo.py` for a start.

Observations and the state are in SI with bounds that are proven but kilometres wide: never scale
by them. A transform squeezes both with symlog.
"""

import argparse
from collections.abc import Sequence
from typing import Any

import torch
from tensordict.nn import TensorDictModule
from torch import Tensor, nn
from torchrl.collectors import Collector
from torchrl.envs import Compose, RewardSum, TransformedEnv, UnaryTransform
from torchrl.envs.libs.pettingzoo import PettingZooWrapper
from torchrl.modules import MLP, MultiAgentMLP, NormalParamExtractor, ProbabilisticActor, TanhNormal
from torchrl.objectives import ClipPPOLoss, ValueEstimators

from swarm_forage_env import parallel_env

DISCOUNT = 0.999
"""Of a decision: a tick (0.1 s) for a weighting."""
OBSERVATION, ACTION, VALUE = ("epuck", "observation"), ("epuck", "action"), ("epuck", "state_value")
REWARD, RETURN = ("epuck", "reward"), ("epuck", "episode_reward")


def symlog(x: Tensor) -> Tensor:
    """sign(x) log(1 + |x|): near x for small numbers, slow for large ones."""
    return torch.sign(x) * torch.log1p(torch.abs(x))


def make_env(seed: int, **options: Any) -> TransformedEnv:
    """The environment, its observations and state squeezed; `options` are `parallel_env`'s."""
    env = PettingZooWrapper(
        parallel_env(discount=DISCOUNT, **options), return_state=True, seed=seed
    )
    squeezed = [OBSERVATION, "state"]
    return TransformedEnv(
        env,
        Compose(
            UnaryTransform(squeezed, squeezed, fn=symlog),
            RewardSum(in_keys=[REWARD], out_keys=[RETURN]),
        ),
    )


def make_policy(env: TransformedEnv) -> ProbabilisticActor:
    """A squashed Gaussian over actions, from a robot's own observation; one for all robots."""
    n_robots, n_observed = env.observation_spec[OBSERVATION].shape
    space = env.full_action_spec[ACTION].space
    network = MultiAgentMLP(
        n_agent_inputs=n_observed,
        n_agent_outputs=2 * space.low.shape[-1],
        n_agents=n_robots,
        centralized=False,  # codespell:ignore centralized
        share_params=True,
        depth=2,
        num_cells=64,
        activation_class=nn.Tanh,
    )
    parameters = [("epuck", "loc"), ("epuck", "scale")]
    return ProbabilisticActor(
        TensorDictModule(
            nn.Sequential(network, NormalParamExtractor()),
            in_keys=[OBSERVATION],
            out_keys=parameters,
        ),
        spec=env.full_action_spec,
        in_keys=parameters,
        out_keys=[ACTION],
        distribution_class=TanhNormal,
        distribution_kwargs={"low": space.low, "high": space.high},
        return_log_prob=True,
    )


def make_critic(env: TransformedEnv) -> TensorDictModule:
    """One value for each robot, from the true state."""
    n_robots, _ = env.observation_spec[OBSERVATION].shape
    n_state = env.observation_spec["state"].shape[-1]
    network = nn.Sequential(
        MLP(n_state, n_robots, num_cells=[64, 64], activation_class=nn.Tanh),
        nn.Unflatten(-1, (n_robots, 1)),
    )
    return TensorDictModule(network, in_keys=["state"], out_keys=[VALUE])


def make_loss(policy: ProbabilisticActor, critic: TensorDictModule) -> ClipPPOLoss:
    """Clipped PPO with GAE; a time-out is bootstrapped, as only "terminated" counts as an end."""
    loss = ClipPPOLoss(
        policy,
        critic,
        clip_epsilon=0.2,
        normalize_advantage=True,
        normalize_advantage_exclude_dims=(-1,),  # one scale for all robots; the last axis is of 1
    )
    loss.set_keys(
        action=ACTION,
        value=VALUE,
        reward=REWARD,
        done=("epuck", "done"),
        terminated=("epuck", "terminated"),
    )
    loss.make_value_estimator(ValueEstimators.GAE, gamma=DISCOUNT, lmbda=0.95)
    return loss


def train(iterations: int, seed: int, steps: int, **options: Any) -> ProbabilisticActor:
    """Train the policy on `steps` decisions of the swarm in each iteration."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)  # quicker for networks this small
    env = make_env(seed, **options)
    policy = make_policy(env)
    loss = make_loss(policy, make_critic(env))
    optimiser = torch.optim.Adam(loss.parameters(), lr=3e-4)
    collector = Collector(env, policy, frames_per_batch=steps, total_frames=iterations * steps)
    for iteration, seen in enumerate(collector, start=1):
        for _ in range(4):
            with torch.no_grad():
                loss.value_estimator(seen)
            for part in seen.reshape(-1)[torch.randperm(steps)].split(max(steps // 8, 1)):
                found = loss(part)
                total = found["loss_objective"] + found["loss_critic"] + found["loss_entropy"]
                optimiser.zero_grad()
                total.backward()
                nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
                optimiser.step()
        earned = seen["next", *RETURN][seen["next", "done"].squeeze(-1)]
        score = f", return {earned.mean():.2f}" if len(earned) else ""
        print(f"iteration {iteration}: loss {total.item():.4f}{score}", flush=True)
    collector.shutdown()
    return policy


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--scenario", default="es1")
    parser.add_argument("--learn", default="weighting", choices=["motion", "weighting", "both"])
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    options = {"scenario": chosen.scenario, "learn": chosen.learn, "max_cycles": 9000}
    if chosen.learn == "motion":
        options |= {"decision_period": 10, "max_cycles": 900, "shaping": 1.0}
    train(chosen.iterations, chosen.seed, 2048, **options)


if __name__ == "__main__":
    main()
