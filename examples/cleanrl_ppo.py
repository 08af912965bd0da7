"""PPO in one file, to read from top to bottom and to copy: needs torch, and nothing hidden.

    pip install 'swarm-forage[train]'
    python examples/cleanrl_ppo.py --scenario es1 --learn motion --iterations 200
    tensorboard --logdir runs/cleanrl_ppo

All robots of all worlds share one policy: a row of every array is one robot. One seed, one
policy, to the last bit. Nobody dies in this world: an episode ends only as its time is out, so
its last observation is valued and bootstrapped, never counted as worth nothing.

Observations are in SI with bounds that are proven but kilometres wide: never scale by them. Most
slots are zero most of the time, which makes a running deviation tiny and the rest huge; so the
network sees symlog(x), which keeps small numbers and tames large ones.

Source: Schulman2017 (PPO), Schulman2016 (GAE), Hafner2023 (symlog).
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import save_file
from torch import Tensor, nn
from torch.distributions import Distribution, Independent, Normal
from torch.utils.tensorboard import SummaryWriter

from swarm_forage_env import parallel_env

HOLD = {"weighting": 1, "both": 1, "motion": 10, "everything": 10}
"""Ticks (0.1 s) for which an action is held: exchanges are seen in the tick they end."""

FORWARD = 0.5
"""Wheel speed that an untrained policy drives with: around zero, no robot finds an area."""


@dataclass(frozen=True)
class Options:
    """What the command line can change."""

    scenario: str = "es1"
    learn: str = "motion"
    seed: int = 1
    iterations: int = 200
    worlds: int = 8
    steps: int = 256  # decisions of every robot in an iteration
    ticks: int = 9000  # of an episode: 0.1 s each
    shaping: float = 1.0  # weight of the potential-based shaping
    discount: float = 0.995  # of a decision: take more where actions are held for less
    trace: float = 0.95  # lambda of GAE
    epochs: int = 4
    minibatches: int = 8
    learning_rate: float = 3e-4
    clip: float = 0.2
    value_weight: float = 0.5
    max_gradient: float = 0.5
    out: str = "runs/cleanrl_ppo"


class Worlds:
    """Several PettingZoo environments as arrays, begun anew when their time is out."""

    def __init__(self, options: Options, **more: Any) -> None:
        """`more` are keywords of `parallel_env`: `physics="kinematic"`, `reward="team"`."""
        terms: dict[str, Any] = {
            "learn": options.learn,
            "decision_period": HOLD[options.learn],
            "max_cycles": options.ticks // HOLD[options.learn],
            "shaping": options.shaping,
            "discount": options.discount,
        }
        self.envs = [parallel_env(options.scenario, **terms, **more) for _ in range(options.worlds)]
        self.agents = self.envs[0].possible_agents
        self.rows = options.worlds * len(self.agents)
        self.n_observed = len(self.envs[0].observation_layout)
        self.n_actions = len(self.envs[0].action_layout)
        names = self.envs[0].action_layout.names
        self.wheels = torch.tensor([name.startswith("wheels.") for name in names])
        space = self.envs[0].action_space(self.agents[0])
        self.low, self.high = space.low, space.high
        self.rng = np.random.default_rng(options.seed)
        self.round_trips: list[float] = []

    def reset(self) -> Tensor:
        """Begin an episode in every world; what every robot observes: (rows, n_observed)."""
        # Seeds from the whole range: the small ones are kept for evaluation.
        found = [env.reset(seed=int(self.rng.integers(2**63)))[0] for env in self.envs]
        return rows_of(found)

    def step(self, action: Tensor) -> tuple[Tensor, Tensor, bool]:
        """Observations, rewards and whether the time is out; [-1, 1] spans an action's bounds."""
        centre, half = (self.high + self.low) / 2, (self.high - self.low) / 2
        scaled: NDArray[np.float32] = np.clip(centre + half * action.numpy(), self.low, self.high)
        of_worlds = scaled.reshape(len(self.envs), len(self.agents), -1)
        observed, infos = [], []
        rewards: list[float] = []
        for env, of_robots in zip(self.envs, of_worlds, strict=True):
            observation, reward, _, truncated, info = env.step(
                dict(zip(self.agents, of_robots, strict=True))
            )
            observed.append(observation)
            rewards.extend(reward.values())
            infos.append(info)
        ended = any(truncated.values())  # worlds of one length end together
        if ended:
            trips = [sum(robot["round_trips"] for robot in info.values()) for info in infos]
            self.round_trips.append(float(np.mean(trips)))
        return rows_of(observed), torch.tensor(rewards, dtype=torch.float32), ended


def rows_of(observations: Sequence[dict[str, NDArray[np.float32]]]) -> Tensor:
    """The observations of all worlds as one matrix, a row for each robot."""
    return torch.from_numpy(np.stack([row for world in observations for row in world.values()]))


class Agent(nn.Module):
    """One policy and one value for every robot: a Gaussian over actions, from what it observes."""

    def __init__(self, n_observed: int, wheels: Tensor) -> None:
        """Two networks; `wheels` tells which actions are wheel speeds, (n_actions,)."""
        super().__init__()
        self.policy = network(n_observed, FORWARD * wheels, gain=0.01)
        self.critic = network(n_observed, torch.zeros(1), gain=1.0)
        self.log_deviation = nn.Parameter(torch.full((len(wheels),), -0.5))

    def act(self, observed: Tensor) -> Distribution:
        """The distribution that actions are drawn from."""
        mean = self.policy(symlog(observed))
        return Independent(Normal(mean, self.log_deviation.exp().expand_as(mean)), 1)

    def value(self, observed: Tensor) -> Tensor:
        """The discounted reward to come."""
        return torch.as_tensor(self.critic(symlog(observed)).squeeze(-1))


def symlog(x: Tensor) -> Tensor:
    """sign(x) log(1 + |x|): near x for small numbers, slow for large ones."""
    return torch.sign(x) * torch.log1p(torch.abs(x))


def network(n_inputs: int, start: Tensor, gain: float, width: int = 64) -> nn.Sequential:
    """Two hidden layers, orthogonal weights; before any training it gives about `start`."""
    first, second, last = (
        nn.Linear(fan_in, fan_out)
        for fan_in, fan_out in ((n_inputs, width), (width, width), (width, len(start)))
    )
    for layer, scale in ((first, 2**0.5), (second, 2**0.5), (last, gain)):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    last.bias.data += start
    return nn.Sequential(first, nn.Tanh(), second, nn.Tanh(), last)


@dataclass(frozen=True)
class Rollout:
    """What one iteration learns from; every array is (steps, rows, ...)."""

    observed: Tensor
    actions: Tensor
    log_probability: Tensor
    advantages: Tensor
    returns: Tensor


@torch.no_grad()
def collect(
    agent: Agent, worlds: Worlds, begin: Tensor, options: Options
) -> tuple[Rollout, Tensor]:
    """Let all robots act for `steps` decisions; also what they observe after the last."""
    shape = options.steps, worlds.rows
    observed = torch.zeros(*shape, worlds.n_observed)
    actions = torch.zeros(*shape, worlds.n_actions)
    log_probability, rewards, values, next_values = (torch.zeros(shape) for _ in range(4))
    ended = torch.zeros(options.steps, 1)
    now = begin
    for t in range(options.steps):
        choice = agent.act(now)
        observed[t], actions[t], values[t] = now, choice.sample(), agent.value(now)
        log_probability[t] = choice.log_prob(actions[t])
        now, rewards[t], time_is_out = worlds.step(actions[t])
        next_values[t] = agent.value(now)  # before a reset: a time-out is no end
        if time_is_out:
            ended[t], now = 1.0, worlds.reset()
    advantages = torch.zeros(shape)
    after = torch.zeros(worlds.rows)
    for t in reversed(range(options.steps)):
        surprise = rewards[t] + options.discount * next_values[t] - values[t]
        after = surprise + options.discount * options.trace * (1.0 - ended[t]) * after
        advantages[t] = after
    return Rollout(observed, actions, log_probability, advantages, advantages + values), now


def update(agent: Agent, optimiser: torch.optim.Adam, seen: Rollout, options: Options) -> float:
    """Several epochs of clipped policy gradient over a rollout; the last loss."""
    flat = {field.name: getattr(seen, field.name).flatten(0, 1) for field in fields(seen)}
    n_samples = len(flat["returns"])
    for _ in range(options.epochs):
        for chosen in torch.randperm(n_samples).chunk(options.minibatches):
            part = {name: values[chosen] for name, values in flat.items()}
            choice = agent.act(part["observed"])
            ratio = (choice.log_prob(part["actions"]) - part["log_probability"]).exp()
            advantage = part["advantages"]
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
            clipped = ratio.clamp(1.0 - options.clip, 1.0 + options.clip)
            policy_loss = -torch.min(ratio * advantage, clipped * advantage).mean()
            value_loss = (agent.value(part["observed"]) - part["returns"]).square().mean()
            loss = policy_loss + options.value_weight * value_loss
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), options.max_gradient)
            optimiser.step()
    return float(loss.item())


def train(options: Options, **more: Any) -> Agent:
    """Train one policy for all robots; weights and curves are written to `out`."""
    torch.manual_seed(options.seed)
    torch.set_num_threads(1)  # quicker for networks this small, and always in the same order
    torch.use_deterministic_algorithms(True)
    worlds = Worlds(options, **more)
    agent = Agent(worlds.n_observed, worlds.wheels)
    optimiser = torch.optim.Adam(agent.parameters(), lr=options.learning_rate, eps=1e-5)
    now = worlds.reset()
    with SummaryWriter(options.out) as writer:
        for iteration in range(1, options.iterations + 1):
            start, n_episodes = time.perf_counter(), len(worlds.round_trips)
            seen, now = collect(agent, worlds, now, options)
            loss = update(agent, optimiser, seen, options)
            decisions = seen.returns.numel()
            speed = decisions * HOLD[options.learn] / (time.perf_counter() - start)
            writer.add_scalar("loss", loss, iteration * decisions)
            writer.add_scalar("robot_steps_per_second", speed, iteration * decisions)
            line = f"iteration {iteration}: loss {loss:.4f}, {speed:,.0f} robot-steps/s"
            if len(worlds.round_trips) > n_episodes:
                writer.add_scalar("round_trips", worlds.round_trips[-1], iteration * decisions)
                line += f", {worlds.round_trips[-1]:.1f} round trips in the last episode"
            print(line, flush=True)
    save_file(agent.state_dict(), Path(options.out) / "policy.safetensors")
    return agent


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    for field in fields(Options):
        flag = "--" + field.name.replace("_", "-")
        known = sorted(HOLD) if field.name == "learn" else None
        parser.add_argument(flag, type=type(field.default), default=field.default, choices=known)
    parser.formatter_class = argparse.ArgumentDefaultsHelpFormatter
    train(Options(**vars(parser.parse_args(arguments))))


if __name__ == "__main__":
    main()
