"""PPO in one file, to read from top to bottom and to copy: needs torch, and nothing hidden.

    pip install 'swarm-forage[train]'
    python examples/cleanrl_ppo.py                              # a few minutes
    swarm-forage evaluate es1 ssgikf torchscript:runs/cleanrl_ppo/policy.pt --seed 1000
    tensorboard --logdir runs/cleanrl_ppo

All robots of all worlds share one policy: a row of every array is one robot. One seed, one
policy, to the last bit. Nobody dies in this world: an episode ends only as its time is out, so
its last observation is valued and bootstrapped, never counted as worth nothing.

Source: Schulman2017 (PPO), Schulman2016 (GAE).
"""

import argparse
import math
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.distributions import Distribution, Independent, Normal
from torch.utils.tensorboard import SummaryWriter

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.array_env import ArrayEnv
from training.policy_card import save_policy_card
from training.policy_controller import policy_controller

HELD_OUT = range(1000, 10**6)
"""Seeds of the episodes that the trained policy is judged by."""


@dataclass(frozen=True)
class Options:
    """What the command line can change."""

    scenario: str = "es1"
    learn: str = "motion"
    seed: int = 1
    iterations: int = 60
    worlds: int = 8
    steps: int = 128  # decisions of every robot in an iteration
    period: int = 10  # ticks (0.1 s) for which an action is held
    shaping: float = 0.0  # weight of the potential-based shaping
    discount: float = 0.99  # of a decision: take more where actions are held for less
    trace: float = 0.95  # lambda of GAE
    epochs: int = 10
    batch: int = 1024
    learning_rate: float = 3e-4
    clip: float = 0.2
    value_clip: float = math.inf  # how far a value moves in an iteration
    value_weight: float = 0.5
    max_gradient: float = 0.5
    episodes: int = 10  # held-out ones
    out: str = "runs/cleanrl_ppo"


def make_env(options: Options, **more: Any) -> ArrayEnv:
    """All worlds in one batch; `more` are keywords of `parallel_env`, as `reward="team"`."""
    return ArrayEnv(options.scenario, options.worlds, **(keywords(options) | more))


def keywords(options: Options) -> dict[str, Any]:
    """What the policy is trained under."""
    return {
        "learn": options.learn,
        "decision_period": options.period,
        "shaping": options.shaping,
        "discount": options.discount,
    }


def rows_of(observations: NDArray[np.float32]) -> Tensor:
    """The observations of all worlds as one matrix, a row for each robot."""
    return torch.from_numpy(observations.reshape(-1, observations.shape[-1]))


class Agent(nn.Module):
    """One policy and one value for every robot: a Gaussian over actions, from what it observes."""

    def __init__(self, n_observed: int, n_actions: int) -> None:
        """Two networks, and a deviation that does not depend on what is observed."""
        super().__init__()
        self.policy = network(n_observed, n_actions, gain=0.01)
        self.critic = network(n_observed, 1, gain=1.0)
        self.log_deviation = nn.Parameter(torch.zeros(n_actions))

    def act(self, observed: Tensor) -> Distribution:
        """The distribution that actions are drawn from."""
        mean = self.policy(observed)
        return Independent(Normal(mean, self.log_deviation.exp().expand_as(mean)), 1)

    def value(self, observed: Tensor) -> Tensor:
        """The discounted reward to come."""
        return torch.as_tensor(self.critic(observed).squeeze(-1))


def network(n_inputs: int, n_outputs: int, gain: float, width: int = 64) -> nn.Sequential:
    """Two hidden layers, orthogonal weights."""
    first, second, last = (
        nn.Linear(fan_in, fan_out)
        for fan_in, fan_out in ((n_inputs, width), (width, width), (width, n_outputs))
    )
    for layer, scale in ((first, 2**0.5), (second, 2**0.5), (last, gain)):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
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
    agent: Agent, env: ArrayEnv, begin: Tensor, options: Options
) -> tuple[Rollout, Tensor, float]:
    """Let all robots act for `steps` decisions; what they observe next, and their round trips."""
    n_rows, n_robots = len(begin), len(env.learners)
    shape, trips = (options.steps, n_rows), 0.0
    observed, actions = (
        torch.zeros(*shape, begin.shape[1]),
        torch.zeros(*shape, len(env.action_layout)),
    )
    log_probability, rewards, values, next_values, ended = (torch.zeros(shape) for _ in range(5))
    now = begin
    for t in range(options.steps):
        choice = agent.act(now)
        observed[t], actions[t], values[t] = now, choice.sample(), agent.value(now)
        log_probability[t] = choice.log_prob(actions[t])
        clamped = actions[t].clamp(-1.0, 1.0).reshape(options.worlds, n_robots, -1)
        reached, reward, _, truncated, infos = env.step(clamped.numpy())
        rewards[t], trips = torch.from_numpy(reward.ravel()), trips + infos["unshaped_reward"].sum()
        next_values[t] = agent.value(rows_of(reached))  # before a reset: a time-out is no end
        if truncated.any():
            ended[t] = torch.from_numpy(truncated).repeat_interleave(n_robots)
            reached, _ = env.reset(worlds=truncated)
        now = rows_of(reached)
    advantages, after = torch.zeros(shape), torch.zeros(n_rows)
    for t in reversed(range(options.steps)):
        surprise = rewards[t] + options.discount * next_values[t] - values[t]
        after = surprise + options.discount * options.trace * (1.0 - ended[t]) * after
        advantages[t] = after
    seen = Rollout(observed, actions, log_probability, advantages, advantages + values)
    return seen, now, float(trips)


def value_error(values: Tensor, part: dict[str, Tensor], clip: float) -> Tensor:
    """The mean squared error of values; of one farther than `clip` from before, the greater."""
    before = part["returns"] - part["advantages"]
    near = values.clamp(before - clip, before + clip)
    errors = ((each - part["returns"]).square() for each in (values, near))
    return torch.maximum(*errors).mean()


def update(agent: Agent, optimiser: torch.optim.Adam, seen: Rollout, options: Options) -> float:
    """Several epochs of clipped policy gradient over a rollout; the last loss."""
    flat = {field.name: getattr(seen, field.name).flatten(0, 1) for field in fields(seen)}
    loss = torch.zeros(())
    for _ in range(options.epochs):
        order = torch.randperm(len(flat["returns"]))
        for chosen in torch.split(order, options.batch):
            part = {name: values[chosen] for name, values in flat.items()}
            choice = agent.act(part["observed"])
            ratio = (choice.log_prob(part["actions"]) - part["log_probability"]).exp()
            advantages = part["advantages"]
            advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
            clipped = ratio.clamp(1.0 - options.clip, 1.0 + options.clip)
            gain = torch.minimum(ratio * advantages, clipped * advantages).mean()
            error = value_error(agent.value(part["observed"]), part, options.value_clip)
            loss = options.value_weight * error - gain
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(agent.parameters(), options.max_gradient)
            optimiser.step()
    return loss.item()


def train(options: Options, **more: Any) -> Agent:
    """Train for so many iterations; `more` are keywords of `parallel_env`."""
    torch.manual_seed(options.seed)
    torch.set_num_threads(1)  # quicker for networks this small, and the same on every machine
    torch.use_deterministic_algorithms(True)
    env = make_env(options, **more)
    agent = Agent(len(env.observation_layout), len(env.action_layout))
    optimiser = torch.optim.Adam(agent.parameters(), lr=options.learning_rate, eps=1e-5)
    now = rows_of(env.reset(seed=options.seed)[0])
    with SummaryWriter(options.out) as writer:
        for iteration in range(1, options.iterations + 1):
            start = time.perf_counter()
            seen, now, trips = collect(agent, env, now, options)
            loss = update(agent, optimiser, seen, options)
            steps = seen.returns.numel() * options.period
            speed = steps / (time.perf_counter() - start)
            rate = trips / options.worlds * env.max_cycles / options.steps
            for name, number in (("loss", loss), ("round_trips", rate), ("speed", speed)):
                writer.add_scalar(name, number, iteration * steps)
            rates = f"{rate:6.1f} round trips an episode, {speed:9,.0f} robot-steps/s"
            print(f"{iteration * steps:10,} robot-steps: {rates}", flush=True)
    save(agent, options, **more)
    return agent


def save(agent: Agent, options: Options, **more: Any) -> None:
    """Keep the policy as TorchScript, with a card of what it was trained under."""
    file = Path(options.out) / "policy.pt"
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "`torch.jit")  # torch prefers torch.export
        torch.jit.script(agent.policy).save(file)  # type: ignore[no-untyped-call]
    save_policy_card(file, options.scenario, **(keywords(options) | more))


def compare(options: Options, agent: Agent) -> dict[str, float]:
    """Print the mean round trips of an episode of the saved policy, and of some to compare with."""
    rng, env = np.random.default_rng(0), make_env(options)
    n_actions = len(env.action_layout)

    def wander(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        return rng.uniform(-1.0, 1.0, (len(observed), n_actions)).astype(np.float32)

    @torch.no_grad()
    def stochastic(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        drawn: NDArray[np.float32] = agent.act(torch.from_numpy(observed)).sample().numpy()
        return drawn

    terms: dict[str, Any] = {"learn": options.learn, "decision_period": options.period}
    controllers: dict[str, Any] = {
        "random": policy_controller(wander, **terms),
        "ssgikf, hand-written": find_controller("ssgikf"),
        "the trained policy": find_controller(f"torchscript:{options.out}/policy.pt"),
        "the same, stochastic": policy_controller(stochastic, **terms),
    }
    trips = {}
    for name, controller in controllers.items():
        seen = run_episodes(env.world.scenario, controller, HELD_OUT[: options.episodes])
        trips[name] = float(np.mean([episode.round_trips for episode in seen]))
        print(f"{name:>22}: {trips[name]:6.1f} round trips an episode")
    return trips


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line, train, and compare on episodes that it was not trained on."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    for field in fields(Options):
        flag = "--" + field.name.replace("_", "-")
        parser.add_argument(flag, type=type(field.default), default=field.default)
    parser.formatter_class = argparse.ArgumentDefaultsHelpFormatter
    options = Options(**vars(parser.parse_args(arguments)))
    compare(options, train(options))
    print(f"watch it: swarm-forage watch {options.scenario} torchscript:{options.out}/policy.pt")


if __name__ == "__main__":
    main()
