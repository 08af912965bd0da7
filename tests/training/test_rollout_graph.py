"""A decision as a graph: repeated by what stands for a GPU's, a rollout is the rollout."""

from contextlib import contextmanager, nullcontext
from copy import deepcopy
from types import SimpleNamespace

import pytest
import torch

from swarm_forage_env import array_env
from training.actor_critic import ActorCritic
from training.cuda_graphs import WARM_UP, Repeated
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import Step, TensorVecEnv

WORLDS = {"n_worlds": 3, "physics": "kinematic", "task.n_robots": 4, "max_cycles": 4}
TERMS = PPOHyperparameters(n_steps=6, n_epochs=2, n_minibatches=2)


class Graph:
    """Does again what was called while it was recorded, which did nothing then."""

    recording = None

    def replay(self):
        """Call the function again."""
        self.again()


def noted(work):
    """Work that the graph that is being recorded knows, in the place of CUDA."""

    def call():
        if Graph.recording:
            Graph.recording.again = work
        else:
            work()

    return call


@pytest.fixture
def _recorder(monkeypatch):
    """What records graphs, without a GPU."""

    @contextmanager
    def recorded(graph, stream):
        assert stream is aside
        Graph.recording = graph
        yield
        Graph.recording = None

    aside, usual = (SimpleNamespace(wait_stream=lambda other: None) for _ in range(2))
    for name, fake in {
        "CUDAGraph": Graph, "graph": recorded, "Stream": lambda: aside,
        "current_stream": lambda: usual, "stream": nullcontext,
    }.items():  # fmt: skip
        monkeypatch.setattr(torch.cuda, name, fake)


def learner_of(policy):
    """A learner on twelve rows, whose episodes end within a rollout."""
    return PPOLearner(TensorVecEnv([array_env("es1", **WORLDS)]), policy, TERMS)


@pytest.mark.usefixtures("_recorder")
def test_a_rollout_of_graphs_is_the_rollout():
    torch.manual_seed(0)
    n_observed = len(learner_of(ActorCritic(1, 2)).env.observation_layout)
    policy, calls = ActorCritic(n_observed, 2), []
    usual, graphed = (learner_of(deepcopy(policy)) for _ in range(2))
    decide, env = graphed._decide, graphed.env
    graphed._repeated = Repeated(
        noted(lambda: calls.append("decided") or decide()), lambda: calls.append("counted")
    )
    env.launch = env.step
    for learner in (usual, graphed):
        learner.learn(2 * 72 * 10, seed=3)
    assert calls == ["counted", "decided"] * 12
    assert graphed._repeated._n_calls == 12 > WARM_UP
    mine, his = usual.state(), graphed.state()
    for name, array in mine.items():
        assert (array == his[name]).all(), name


def test_a_decision_waits_for_no_number():
    """Tensors without memory: whoever asks for a number is refused, as in a graph."""
    learner, of = learner_of(ActorCritic(45, 2)), torch.device("meta")
    step = Step(*(torch.zeros(shape, device=of) for shape in ((12, 45), 12, (12, 45), 12)))
    learner.env = SimpleNamespace(
        n_rows=12, device=torch.device("cuda"), acts=step.ended > 0.0, check=lambda: None,
        launch=lambda actions: step, observation_layout=range(45),
    )  # fmt: skip
    learner._networks.numbers = torch.nn.Parameter(learner._networks.numbers.to(of))
    for name in ("_k", "_low", "_high", "_states"):
        setattr(learner, name, getattr(learner, name).to(of))
    learner._rollout, learner._repeated = learner._empty_rollout(), learner
    with torch.no_grad():
        learner._decide()
    assert learner._rollout.rewards.is_meta
