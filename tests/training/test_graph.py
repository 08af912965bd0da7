"""Graphs of who heard whom: what the records say, of any robots in any order."""

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env import ArrayEnv, ConfigError
from training.graph import Edges, Graphs

CHATTY = {"physics": "kinematic", "task.n_robots": 6, "radio.max_range": 0.6, "learn": "everything"}
"""Robots that are near, and speak where their policy wants."""


def env_of(n_worlds=2, **keywords):
    return ArrayEnv("es1", n_worlds, **{**CHATTY, "observation": ["layer", Edges], **keywords})


def edges_of(graph):
    """Sender, receiver and beam of each edge, in order."""
    index, beams = graph.edge_index.T.tolist(), graph.edge_attr.tolist()
    return sorted((*ends, *beam) for ends, beam in zip(index, beams, strict=True))


def test_a_graph_worked_out_by_hand():
    env = env_of(**{"task.n_robots": 3})
    names = env.observation_layout.names
    at = {name: k for k, name in enumerate(names)}
    seen = np.zeros((2, 3, len(names)), np.float32)
    beams = [at[f"edges.beam.{k}.range"] for k in range(2)]
    seen[0, 0, [at["edges.sender.0"], at["edges.sender.1"]]] = 3 / 3, 2 / 3
    seen[0, 0, beams[0] : beams[0] + 3] = 0.5, 0.25, -0.25
    seen[0, 0, beams[1] : beams[1] + 3] = 0.4, 0.75, 0.125
    seen[1, 2, at["edges.sender.0"]] = 1 / 3
    seen[1, 2, beams[0] : beams[0] + 3] = 0.3, -1.0, 0.0
    seen[:, :, 0] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    graphs = Graphs(env)
    graph = graphs(seen)
    assert graph.edge_index.dtype == graph.batch.dtype == torch.int64
    assert graph.edge_index.tolist() == [[2, 1, 3], [0, 0, 5]]
    expected = [[0.5, 0.25, -0.25], [0.4, 0.75, 0.125], [0.3, -1.0, 0.0]]
    assert_allclose(graph.edge_attr, expected, rtol=1e-6)
    assert graph.batch.tolist() == [0, 0, 0, 1, 1, 1]
    assert graph.x.shape == (6, graphs.n_features) == (6, len(names) - 16)
    features, adjacency, edges = graphs.dense(graph)
    assert adjacency.tolist() == [[[0, 1, 1], [0, 0, 0], [0, 0, 0]], [[0] * 3, [0] * 3, [1, 0, 0]]]
    assert (adjacency @ features)[:, :, 0].tolist() == [[5.0, 0.0, 0.0], [0.0, 0.0, 4.0]]
    assert_allclose(edges[adjacency > 0.0], [expected[1], expected[0], expected[2]], rtol=1e-6)
    assert edges[adjacency == 0.0].abs().sum() == 0.0


@pytest.mark.parametrize("normalise", [True, False])
def test_edges_are_who_was_heard_and_nodes_what_is_observed_without_them(normalise):
    env, bare = env_of(3, normalise=normalise), env_of(3, normalise=normalise, observation="layer")
    graphs, rng, n_edges = Graphs(env), np.random.default_rng(0), []
    seen, plain = env.reset(5)[0], bare.reset(5)[0]
    for _ in range(60):
        expected = []
        for w, i in np.ndindex(3, 6):
            heard = env.world.robots["heard"][w, i]
            for k in range(heard["n"]):
                r, *angles = heard["range_bearing"][k]
                beam = [r / (r + 0.1), *np.divide(angles, np.pi)] if normalise else [r, *angles]
                expected.append((w * 6 + heard["sender"][k], w * 6 + i, *beam))
        graph = graphs(seen)
        found = np.array(edges_of(graph)).reshape(-1, 5)
        assert_allclose(found, np.array(sorted(expected)).reshape(-1, 5), rtol=1e-5)
        assert graphs.dense(graph)[1].sum() == len(expected)  # nobody is heard twice in a tick
        assert_array_equal(graph.x, plain.reshape(18, -1))
        n_edges.append(len(expected))
        actions = rng.uniform(-1.0, 1.0, (3, 6, 15)).astype(np.float32)
        seen, plain = env.step(actions)[0], bare.step(actions)[0]
    assert len(set(n_edges)) > 5


def test_what_has_no_graph_is_refused():
    with pytest.raises(
        ConfigError, match=r"observation='layer': has no edges; add training\.graph"
    ):
        Graphs(env_of(observation="layer"))
    with pytest.raises(ConfigError, match="learners=2: each robot is a node"):
        Graphs(env_of(learners=2))
    with pytest.raises(ConfigError, match="robots of a WaypointsScenario have no radio; use"):
        ArrayEnv("waypoints-05", observation=["layer", Edges])
    graphs, n = Graphs(env_of()), len(env_of().observation_layout)
    for shape in ((2, 6, n - 1), (5, n)):
        with pytest.raises(ConfigError, match=r"must be \(worlds, 6, \d+\), or whole worlds"):
            graphs(np.zeros(shape, np.float32))


def test_of_stacked_observations_the_newest_edges_count():
    one, three = env_of(), env_of(stack=3)
    for env in (one, three):
        env.reset(2)
    for _ in range(3):
        plain, stacked = (
            Graphs(env)(env.step(np.ones((2, 6, 15), np.float32))[0]) for env in (one, three)
        )
    assert_array_equal(stacked.edge_index, plain.edge_index)
    assert_array_equal(stacked.edge_attr, plain.edge_attr)
    assert stacked.x.shape[1] == 3 * plain.x.shape[1]
