"""An epoch as a graph: repeated operation by operation on tensors that stay, it is the epoch."""

from contextlib import nullcontext, suppress
from copy import deepcopy
from types import SimpleNamespace

import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves, tree_map

from swarm_forage_env import ConfigError, array_env
from training.actor_critic import ActorCritic
from training.cuda_graphs import WARM_UP, Repeated, in_tf32
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv

WORLDS = {"n_worlds": 2, "physics": "kinematic", "task.n_robots": 4, "max_cycles": 6}
TERMS = PPOHyperparameters(n_steps=6, n_epochs=3, n_minibatches=5)


class Graph:
    """In the place of CUDA's: knows operations and their tensors, and no line of Python."""

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

    def __init__(self, graph, stream):
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


@pytest.fixture
def _recorder(monkeypatch):
    stream = SimpleNamespace(wait_stream=lambda other: None)
    for name, fake in {
        "CUDAGraph": Graph, "graph": Recorder, "Stream": lambda: stream,
        "current_stream": lambda: stream, "stream": nullcontext,
    }.items():  # fmt: skip
        monkeypatch.setattr(torch.cuda, name, fake)


@pytest.mark.usefixtures("_recorder")
def test_an_update_of_graphs_is_the_update():
    env = TensorVecEnv([array_env("es1", **WORLDS)])
    policies = [ActorCritic(len(env.observation_layout), 2) for _ in range(2)]
    usual, graphed = (
        PPOLearner(TensorVecEnv([array_env("es1", **WORLDS)]), deepcopy(policies), TERMS)
        for _ in range(2)
    )
    for learner in (usual, graphed):
        (group,) = learner._adam._adam.param_groups
        group["fused"] = True  # as on a GPU: it asks for no number
    graphed._repeated_epoch = Repeated(graphed._epoch)
    for learner in (usual, graphed):
        learner.learn(3 * 6 * 10 * 4, seed=3)
    assert graphed._repeated_epoch._n_calls == 3 * TERMS.n_epochs > WARM_UP
    usual.restore(graphed.state(1))
    graphed.restore(graphed.state(1))
    for learner in (usual, graphed):
        learner.learn(1, seed=4)
    for k in range(2):
        mine, his = usual.state(k), graphed.state(k)
        for name, array in mine.items():
            assert (array == his[name]).all(), name
    assert graphed.diagnostics == usual.diagnostics


def test_tensor_cores_are_for_the_time_of_a_learner():
    before = torch.get_float32_matmul_precision()
    with suppress(ConfigError), in_tf32():
        assert torch.get_float32_matmul_precision() == "high" != before
        raise ConfigError("an action is refused")
    assert torch.get_float32_matmul_precision() == before
