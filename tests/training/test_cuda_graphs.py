"""Graphs of an update: recorded and replayed by what stands for a GPU's, they learn the same."""

from contextlib import contextmanager, nullcontext
from copy import deepcopy
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from swarm_forage_env import array_env
from training.actor_critic import ActorCritic
from training.cuda_graphs import Graphed
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv


class Graph:
    """Does again what was called while it was recorded, into the same tensors."""

    def replay(self):
        """Call the function again, and overwrite what it returned."""
        with torch.no_grad():
            kept = self.again()
            for there, here in zip(self.returned, kept, strict=True):
                there.copy_(here)


@pytest.fixture
def recorder(monkeypatch):
    """What makes a function known to the graph that is being recorded, in the place of CUDA."""
    calls = []

    def noted(work):
        def call(*given):
            with torch.enable_grad():
                returned = tuple(each.detach() for each in work(*given))
            calls.append((lambda: call(*given), returned))
            return returned

        return call

    @contextmanager
    def recorded(graph):
        yield
        graph.again, graph.returned = calls[-1]

    stream = SimpleNamespace(wait_stream=lambda other: None)
    for name, fake in {
        "CUDAGraph": Graph, "graph": recorded, "Stream": lambda: stream,
        "current_stream": lambda: stream, "stream": nullcontext,
    }.items():  # fmt: skip
        monkeypatch.setattr(torch.cuda, name, fake)
    return noted


def learner_of(policy):
    """A learner on twelve rows, whose minibatches have two sizes."""
    env = TensorVecEnv([array_env("es1", n_worlds=3, physics="kinematic", **{"task.n_robots": 4})])
    terms = PPOHyperparameters(n_steps=5, n_epochs=2, n_minibatches=7)
    return PPOLearner(env, policy, terms)


def test_an_update_of_graphs_is_the_update(recorder):
    torch.manual_seed(0)
    policy = ActorCritic(len(learner_of(ActorCritic(1, 2)).env.observation_layout), 2)
    usual, graphed = (learner_of(deepcopy(policy)) for _ in range(2))
    graphed._learn = Graphed(recorder(graphed._learn_from), list(graphed._tensors.values()))
    for learner in (usual, graphed):
        learner.learn(2 * 60 * 10, seed=3)
    assert len(graphed._learn._recorded) == 2
    np.testing.assert_equal(graphed.state(), usual.state())
    assert_close(usual.diagnostics, graphed.diagnostics)


def test_an_update_waits_for_no_number():
    """Tensors without memory: whoever asks for a number is refused, as in a graph."""
    learner = learner_of(ActorCritic(6, 2))
    learner.policy = learner.policy.to("meta")
    step = SimpleNamespace(zero_grad=lambda: None, step=lambda: None)
    learner._optimizer = step  # that of a GPU asks for none, by `capturable`
    of = torch.device("meta")
    batch = (torch.zeros(shape, device=of) for shape in ((9, 6), (9, 2), 9, 9, 9))
    assert all(each.is_meta for each in learner._learn_from(*batch))
