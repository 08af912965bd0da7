"""Decisions and epochs as graphs: repeated by what stands for a GPU's, they do what they do."""

from contextlib import contextmanager, nullcontext, suppress
from copy import deepcopy
from types import SimpleNamespace

import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves, tree_map

from swarm_forage_env import ConfigError, array_env
from training.actor_critic import ActorCritic
from training.cuda_graphs import WARM_UP, GraphedFunction, in_tf32
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import Step, TensorVecEnv

WORLDS = {"n_worlds": 3, "physics": "kinematic", "task.n_robots": 4, "max_cycles": 4}
"""Twelve rows, whose episodes end within a rollout."""

TERMS = PPOHyperparameters(n_steps=6, n_epochs=2, n_minibatches=2)


def learner_of(policy, terms=TERMS, **changes):
    """A learner on those worlds."""
    return PPOLearner(TensorVecEnv([array_env("es1", **WORLDS | changes)]), policy, terms)


def policy_of():
    """A policy for those worlds."""
    return ActorCritic(len(array_env("es1", **WORLDS).observation_layout), 2)


@pytest.fixture
def record_by(monkeypatch):
    """Let graphs be of a class, and be recorded by a context, without a GPU."""

    def replace(graph, recorder):
        own_stream, usual = (SimpleNamespace(wait_stream=lambda other: None) for _ in range(2))

        def recorded(graph, stream):
            assert stream is own_stream
            return recorder(graph)

        for name, fake in {
            "CUDAGraph": graph, "graph": recorded, "Stream": lambda: own_stream,
            "current_stream": lambda: usual, "stream": nullcontext,
        }.items():  # fmt: skip
            monkeypatch.setattr(torch.cuda, name, fake)

    return replace


class Calls:
    """Does again what was called while it was recorded, which did nothing then."""

    recording = None

    def replay(self):
        """Call the function again."""
        self.again()


def noted(work):
    """Work that the graph that is being recorded knows, in the place of CUDA."""

    def call():
        if Calls.recording:
            Calls.recording.again = work
        else:
            work()

    return call


@contextmanager
def recorded_calls(graph):
    Calls.recording = graph
    yield
    Calls.recording = None


def test_a_rollout_of_graphs_is_the_rollout(record_by):
    record_by(Calls, recorded_calls)
    torch.manual_seed(0)
    policy, calls = policy_of(), []
    usual, graphed = (learner_of(deepcopy(policy)) for _ in range(2))
    decide, env = graphed._decide, graphed.env
    graphed._repeated = GraphedFunction(
        noted(lambda: calls.append("decided") or decide()), lambda: calls.append("counted")
    )
    env.launch = env.step
    for learner in (usual, graphed):
        learner.learn(2 * 72 * 10, seed=3)
    assert calls == ["counted", "decided"] * 12
    assert graphed._repeated._n_calls == 12 > WARM_UP
    check_same_state(usual, graphed)


def check_same_state(one, other, k=0):
    mine, his = one.state(k), other.state(k)
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


class Operations:
    """In the place of CUDA's graph: knows operations and their tensors, and no line of Python."""

    def __init__(self):
        self.operations = []

    def replay(self):
        """Do all operations again, into the same tensors."""
        for operation, given, named, found in self.operations:
            again = tree_leaves(operation(*given, **named))
            for there, here in zip(tree_leaves(found), again, strict=True):
                if isinstance(there, torch.Tensor) and there.data_ptr() != here.data_ptr():
                    there.copy_(here)


class Recorder(TorchDispatchMode):
    """Records the operations within it, and undoes them; who waits for a number is refused."""

    def __init__(self, graph):
        super().__init__()
        self._graph, self._before = graph, {}

    def __exit__(self, *error):
        super().__exit__(*error)
        for tensor, before in self._before.values():
            tensor.copy_(before)

    def __torch_dispatch__(self, operation, types, given=(), named=None):
        assert operation is not torch.ops.aten._local_scalar_dense.default
        for argument, value in zip(operation._schema.arguments, given, strict=False):
            if argument.is_write:
                for each in map(_without_gradient, tree_leaves(value)):
                    self._before.setdefault(each.data_ptr(), (each, each.clone()))
        found = operation(*given, **named or {})
        noted = tree_map(_without_gradient, (given, named or {}, found))
        self._graph.operations.append((operation, *noted))
        return found


def _without_gradient(each):
    return each.detach() if isinstance(each, torch.Tensor) else each


def test_an_update_of_graphs_is_the_update(record_by):
    record_by(Operations, Recorder)
    terms = PPOHyperparameters(n_steps=6, n_epochs=3, n_minibatches=5)
    policies = [policy_of() for _ in range(2)]
    usual, graphed = (
        learner_of(deepcopy(policies), terms, n_worlds=2, max_cycles=6) for _ in range(2)
    )
    for learner in (usual, graphed):
        (group,) = learner._adam._adam.param_groups
        group["fused"] = True  # as on a GPU: it asks for no number
    graphed._repeated_epoch = GraphedFunction(graphed._epoch)
    for learner in (usual, graphed):
        learner.learn(3 * 6 * 10 * 4, seed=3)
    assert graphed._repeated_epoch._n_calls == 3 * terms.n_epochs > WARM_UP
    usual.restore(graphed.state(1))
    graphed.restore(graphed.state(1))
    for learner in (usual, graphed):
        learner.learn(1, seed=4)
    for k in range(2):
        check_same_state(usual, graphed, k)
    assert graphed.diagnostics == usual.diagnostics


def test_tensor_cores_are_for_the_time_of_a_learner():
    before = torch.get_float32_matmul_precision()
    with suppress(ConfigError), in_tf32():
        assert torch.get_float32_matmul_precision() == "high" != before
        raise ConfigError("an action is refused")
    assert torch.get_float32_matmul_precision() == before
