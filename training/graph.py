"""Graphs of the received messages, for graph neural networks.

    env = ArrayEnv("es1", n_worlds=8, observation=["layer", Edges])
    graphs = Graphs(env)
    observations, _ = env.reset(seed=0)
    graph = graphs(observations)

The observation contains the edges, so that any observations can be converted: those of a step, the
last ones of episodes, a minibatch of whole worlds, or one world in an evaluation.
`torch_geometric.data.Data(**vars(graph))` is the graph in PyTorch Geometric.
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
"""Prefix of the names of edge features."""

SENDER, BEAM = f"{PART}.sender.", f"{PART}.beam."

PER_SLOT = 4
"""Number of features of a message slot: the sender and the three features of its beam."""

BEAMS = FieldPath(PART, "robots.heard", Heard, "range_bearing")


class Edges:
    """Observation of the messages received in the last tick, as edges of a graph.

    The first features are the sender of each message slot, counted from 1, or 0 if the slot is
    empty. Then follow, for each slot, the measured range [m] and bearing [rad] of the sender, and
    the bearing of the receiver from the sender [rad]. Empty slots are zero.
    """

    def features(self, scenario: BaseScenario, agents: Sequence[str]) -> Sequence[Feature]:
        """Describe each feature. ConfigError if the robots of the scenario have no radio."""
        if not isinstance(scenario, EpuckScenario):
            raise ConfigError(
                f"observation={type(self).__name__}: observes received radio messages, but"
                f" robots of a {type(scenario).__name__} have no radio; use a scenario of"
                " e-pucks, such as es1"
            )
        n = scenario.radio.slots
        senders = [Feature(f"{SENDER}{k}", "number, from 1", 0.0, len(agents)) for k in range(n)]
        return [*senders, *BEAMS.features({"slots": n}, scenario)]

    def write(
        self, context: ObservationContext, out: Float32[Array, "worlds robots numbers"]
    ) -> None:
        """Write the messages that every robot received."""
        heard, n = context.robots["heard"], out.shape[2] // PER_SLOT
        is_valid = np.arange(n) < heard["n"][..., None]
        out[..., :n] = np.where(is_valid, heard["sender"][..., :n] + 1, 0)
        out[..., n:] = heard["range_bearing"][..., :n, :].reshape(*out.shape[:2], -1)


@dataclass(frozen=True)
class Graph:
    """The robots of several worlds as one graph, in the layout of PyTorch Geometric.

    Node `world * n_robots + robot` is a robot; an edge is a received message.
    """

    x: Tensor
    """Observation of each robot without the edges, shape (nodes, features)."""
    edge_index: Tensor
    """Sender and receiver of each message, shape (2, edges), int64, in the order of receivers."""
    edge_attr: Tensor
    """Range and both bearings of each message, scaled as observed, shape (edges, 3)."""
    batch: Tensor
    """World of each node, int64."""


class Graphs:
    """Conversion of the observations of an environment to graphs, on the device of the tensors."""

    def __init__(self, env: ArrayEnv) -> None:
        """Find the edges in the observations of an environment.

        ConfigError if the observations have no edges, or if some robots do not learn. In stacked
        observations the newest edges are used.
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
                f"learners={env.config.learners!r}: each robot is a node of the graph and must"
                " observe, but only learners do; leave learners out"
            )
        self.n_robots, self._n_observed = len(env.agents), len(names)
        self._scale = self.n_robots / env.observation_layout[self._senders[0]].high

    @property
    def n_features(self) -> int:
        """Number of features of a node."""
        return len(self._features)

    def __call__(self, observations: object) -> Graph:
        """Return the graph of observations (worlds, robots, features), or of one row per robot.

        ConfigError for another number of features, and for rows that are not whole worlds.
        """
        tensor = torch.as_tensor(observations)
        n_numbers = tensor.shape[-1]
        if n_numbers != self._n_observed or tensor.numel() % (self.n_robots * n_numbers):
            raise ConfigError(
                f"observations of shape {tuple(tensor.shape)}: must be (worlds, {self.n_robots},"
                f" {self._n_observed}), or whole worlds as rows of {self._n_observed} numbers"
            )
        rows = tensor.reshape(-1, n_numbers)
        senders = (rows[:, self._senders] * self._scale).round().long()
        receiver, slot = senders.nonzero(as_tuple=True)
        world = torch.arange(len(rows), device=rows.device) // self.n_robots
        sender = world[receiver] * self.n_robots + senders[receiver, slot] - 1
        beams = rows[:, self._beams].reshape(len(rows), -1, PER_SLOT - 1)
        index = torch.stack((sender, receiver))
        return Graph(rows[:, self._features], index, beams[receiver, slot], world)

    def dense(self, graph: Graph) -> tuple[Tensor, Tensor, Tensor]:
        """Return node features, adjacency matrices and edge features as dense tensors.

        Node features are (worlds, robots, features). Adjacency is (worlds, receivers, senders): 1
        for a message, else 0, so that `adjacency @ features` sums over the senders of each robot.
        Edge features are (worlds, receivers, senders, 3), zero without a message.
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
