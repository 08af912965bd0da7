"""Graphs of who heard whom, for networks that pass messages between robots.

    env = ArrayEnv("es1", n_worlds=8, observation=["layer", Edges])
    graphs = Graphs(env)
    observations, _ = env.reset(seed=0)
    graph = graphs(observations)

The observation holds the edges, so that a network makes the graph of whatever it is given: of a
step, of the last observations of episodes, of a minibatch of whole worlds, of one world in an
evaluation. `torch_geometric.data.Data(**vars(graph))` is the graph in PyTorch Geometric.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.extra_observations import ObservationContext
from swarm_forage_env.epuck.records import Heard
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.observed_fields import FieldPath
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.spaces import Feature

PART = "edges"
"""The name of a number of an edge begins with it."""

SENDER, BEAM = f"{PART}.sender.", f"{PART}.beam."

PER_SLOT = 4
"""Numbers of a message slot: the sender, and the beam."""

BEAMS = FieldPath(PART, "robots.heard", Heard, "range_bearing")


class Edges:
    """An observation: the messages that a robot heard in the last tick, as edges of a graph.

    First the number of the sender of each message slot, from 1, or 0 where the slot is empty; then
    for each slot the range of the sender [m], its bearing and the bearing back [rad], as measured.
    An empty slot is zeros.
    """

    def features(self, scenario: BaseScenario, agents: Sequence[str]) -> Sequence[Feature]:
        """What each number is; ConfigError in a scenario whose robots have no radio."""
        if not isinstance(scenario, EpuckScenario):
            raise ConfigError(
                f"observation={type(self).__name__}: shows who was heard by radio, and robots of a"
                f" {type(scenario).__name__} have none; take a scenario of e-pucks, as es1"
            )
        n = scenario.radio.slots
        senders = [Feature(f"{SENDER}{k}", "number, from 1", 0.0, len(agents)) for k in range(n)]
        return [*senders, *BEAMS.features({"slots": n}, scenario)]

    def write(
        self, context: ObservationContext, out: Float32[Array, "worlds robots numbers"]
    ) -> None:
        """Write what every robot heard."""
        heard, n = context.robots["heard"], out.shape[2] // PER_SLOT
        is_valid = np.arange(n) < heard["n"][..., None]
        out[..., :n] = np.where(is_valid, heard["sender"][..., :n] + 1, 0)
        out[..., n:] = heard["range_bearing"][..., :n, :].reshape(*out.shape[:2], -1)


@dataclass(frozen=True)
class Graph:
    """The robots of some worlds as one graph, in PyTorch Geometric's layout.

    Node `world * n_robots + robot` is a robot, an edge is a message that was heard.
    """

    x: Tensor
    """What each robot observes beside the edges: nodes by features."""
    edge_index: Tensor
    """Sender and receiver of each message: 2 by edges, int64; in the order of receivers."""
    edge_attr: Tensor
    """Range, bearing and bearing back of each message, scaled as observed: edges by 3."""
    batch: Tensor
    """The world of each node, int64."""


class Graphs:
    """Makes graphs of what the robots of an environment observe, on the device of the tensors."""

    def __init__(self, env: ArrayEnv) -> None:
        """Find the edges in the observations of an environment.

        ConfigError for one whose observations have none, or in which some robots do not learn.
        Of stacked observations the newest edges count.
        """
        names = env.observation_layout.names
        self._senders = [k for k, name in enumerate(names) if name.startswith(SENDER)]
        self._beams = [k for k, name in enumerate(names) if name.startswith(BEAM)]
        self._features = [k for k, name in enumerate(names) if f"{PART}." not in name]
        if not self._senders:
            raise ConfigError(
                f"observation={env.config.observation!r}: has no edges; add training.graph.Edges,"
                " as in observation=['layer', Edges]"
            )
        if len(env.learners) < len(env.agents):
            raise ConfigError(
                f"learners={env.config.learners!r}: only learners observe, and each robot is a"
                " node of the graph; leave learners out"
            )
        self.n_robots, self._n_observed = len(env.agents), len(names)
        self._scale = self.n_robots / env.observation_layout[self._senders[0]].high

    @property
    def n_features(self) -> int:
        """Numbers of a node."""
        return len(self._features)

    def __call__(self, observations: object) -> Graph:
        """The graph of observations: worlds by robots by numbers, or a row for each robot.

        ConfigError for other numbers, and for rows that are not whole worlds.
        """
        seen = torch.as_tensor(observations)
        n_numbers = seen.shape[-1]
        if n_numbers != self._n_observed or seen.numel() % (self.n_robots * n_numbers):
            raise ConfigError(
                f"observations of shape {tuple(seen.shape)}: must be (worlds, {self.n_robots},"
                f" {self._n_observed}), or whole worlds as rows of {self._n_observed} numbers"
            )
        rows = seen.reshape(-1, n_numbers)
        senders = (rows[:, self._senders] * self._scale).round().long()
        receiver, slot = senders.nonzero(as_tuple=True)
        world = torch.arange(len(rows), device=rows.device) // self.n_robots
        sender = world[receiver] * self.n_robots + senders[receiver, slot] - 1
        beams = rows[:, self._beams].reshape(len(rows), -1, PER_SLOT - 1)
        index = torch.stack((sender, receiver))
        return Graph(rows[:, self._features], index, beams[receiver, slot], world)

    def dense(self, graph: Graph) -> tuple[Tensor, Tensor, Tensor]:
        """The graph padded: features, adjacency, and features of edges, by worlds.

        Features are worlds by robots by features. Adjacency is worlds by receivers by senders: 1
        for a message, else 0, so that `adjacency @ features` sums over the senders of each robot.
        Features of edges are worlds by receivers by senders by 3, zeros where nothing was heard.
        """
        sender, receiver = graph.edge_index
        n = self.n_robots
        where = graph.batch[receiver], receiver % n, sender % n
        features = graph.x.reshape(len(graph.x) // n, n, self.n_features)
        adjacency = features.new_zeros((len(features), n, n))
        adjacency[where] = 1.0
        edges = features.new_zeros((*adjacency.shape, PER_SLOT - 1))
        edges[where] = graph.edge_attr
        return features, adjacency, edges
