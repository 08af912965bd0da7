"""PPO of a graph network: each robot acts on what it observes and on messages of those it heard.

    pip install 'swarm-forage[train]'
    python examples/graph_ppo.py                                 # a few minutes
    python examples/graph_ppo.py --scenario near --worlds 16

Nodes are robots, edges are who was heard in the last tick. A message is a learned function of what
its sender observes and of the beam, and a robot sums those that it hears: one layer of message
passing. So robots tell each other 32 learned numbers, which is more than the hand-written
controllers say. All robots share the network, and a permutation of them permutes their actions.

Source: Gilmer2017 (message passing), Schulman2017 (PPO).
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.array_env import ArrayEnv
from training.actor_critic import ActorCritic
from training.graph import Edges, Graphs
from training.policy_controller import policy_controller
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv

HELD_OUT = range(1000, 10**6)
"""Seeds of the episodes that the trained policy is judged by."""

KEYWORDS: dict[str, Any] = {
    "learn": "motion",
    "decision_period": 10,
    "observation": ["layer", Edges],
}
"""What the policy is trained under."""


@dataclass(frozen=True)
class Options:
    """What the command line can change."""

    scenario: str = "es1"
    seed: int = 1
    robot_steps: int = 3_000_000
    worlds: int = 8
    episodes: int = 10  # held-out ones


class GraphNetwork(nn.Module):
    """One layer of message passing, and two dense ones over what a robot observes and hears."""

    def __init__(self, graphs: Graphs, n_outputs: int, gain: float) -> None:
        """Random weights; the last ones are scaled by the gain."""
        super().__init__()
        self.graphs, n, n_said, width = graphs, graphs.n_features, 32, 64
        self.message = nn.Sequential(nn.Linear(n + 3, n_said), nn.Tanh())
        self.head = nn.Sequential(
            nn.Linear(n + n_said, width), nn.Tanh(), nn.Linear(width, width), nn.Tanh()
        )
        self.last = nn.Linear(width, n_outputs)
        nn.init.orthogonal_(self.last.weight, gain)
        nn.init.zeros_(self.last.bias)

    def forward(self, observed: Tensor) -> Tensor:
        """Outputs of each robot; rows are the robots of whole worlds."""
        graph = self.graphs(observed)
        sender, receiver = graph.edge_index
        sent = self.message(torch.cat((graph.x[sender], graph.edge_attr), 1))
        heard = sent.new_zeros(len(graph.x), sent.shape[1]).index_add(0, receiver, sent)
        return torch.as_tensor(self.last(self.head(torch.cat((graph.x, heard), 1))))


def make_env(options: Options, **more: Any) -> ArrayEnv:
    """All worlds in one batch; `more` are keywords of `parallel_env`."""
    return ArrayEnv(options.scenario, options.worlds, stagger=True, **KEYWORDS, **more)


def train(options: Options, **more: Any) -> ActorCritic:
    """Train for so many robot-steps; `more` are keywords of `parallel_env`."""
    torch.manual_seed(options.seed)
    torch.set_num_threads(1)  # quicker for networks this small
    env = make_env(options, **more)
    graphs, n_actions = Graphs(env), len(env.action_layout)
    policy = ActorCritic(graphs.n_features, n_actions)
    policy.actor = GraphNetwork(graphs, n_actions, gain=0.01)
    policy.critic = GraphNetwork(graphs, 1, gain=1.0)
    terms = PPOHyperparameters(rows_together=graphs.n_robots)
    learner, every = PPOLearner(TensorVecEnv([env]), policy, terms), -(-options.robot_steps // 10)
    for part in range(10):
        learner.learn(every, options.seed if part == 0 else None)
        reward = learner.diagnostics["train/reward"] * env.max_cycles * graphs.n_robots
        print(f"{learner.robot_steps:10,} robot-steps: reward {reward:6.1f} an episode", flush=True)
    return policy


Act = Callable[[NDArray[np.float32]], NDArray[np.float32]]


def acting(policy: Callable[[Tensor], Tensor]) -> Act:
    """A policy as a function of what the robots of a world observe."""

    @torch.no_grad()
    def act(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        actions: NDArray[np.float32] = policy(torch.from_numpy(observed)).numpy()
        return actions

    return act


def compare(options: Options, policy: ActorCritic, **more: Any) -> dict[str, float]:
    """Print the mean round trips of an episode of the policy, and of some to compare with."""
    rng, env = np.random.default_rng(0), make_env(options, **more)
    n_actions = len(env.action_layout)

    def wander(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        return rng.uniform(-1.0, 1.0, (len(observed), n_actions)).astype(np.float32)

    controllers: dict[str, Any] = {
        "random": policy_controller(wander, **KEYWORDS),
        "ssgikf, hand-written": find_controller("ssgikf"),
        "the trained policy": policy_controller(acting(policy.actor), **KEYWORDS),
        "the same, stochastic": policy_controller(acting(policy), **KEYWORDS),
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


if __name__ == "__main__":
    main()
