"""Policies in ONNX, run by onnxruntime as controllers."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete
from numpy.testing import assert_array_equal

import training.controllers  # noqa: F401 the kinds of policies, also where no package is installed
from swarm_forage_env import parallel_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from training.exported_policies import TorchScriptPolicy
from training.policy_card import save_policy_card
from training.policy_controller import policy_controller

SMALL = {"task.n_robots": 4, "task.duration": 60.0}


@pytest.fixture
def file(tmp_path):
    """A function that writes a linear network, which sees so many numbers and gives so many."""
    onnx = pytest.importorskip("onnx", reason="comes with the extra dev")
    pytest.importorskip("onnxruntime", reason="comes with the extra onnx")
    from onnx import TensorProto, helper, numpy_helper

    def make(n_seen, n_given, inputs=("seen",)):
        rng = np.random.default_rng(0)
        weights = rng.normal(0.0, 0.2, (n_seen, n_given)).astype(np.float32)

        def info(name, size):
            return helper.make_tensor_value_info(name, TensorProto.FLOAT, ["robots", size])

        nodes = [helper.make_node("MatMul", ["seen", "weights"], ["given"])]
        of_file, given = [info(name, n_seen) for name in inputs], [info("given", n_given)]
        arrays = [numpy_helper.from_array(weights, "weights")]
        graph = helper.make_graph(nodes, "policy", of_file, given, arrays)
        opset = [helper.make_opsetid("", 13)]
        onnx.save(helper.make_model(graph, opset_imports=opset, ir_version=8), tmp_path / "p.onnx")
        return tmp_path / "p.onnx", weights

    return make


def poses(controller, ticks):
    """Where the robots are after so many ticks."""
    loop = Loop(find_scenario("es1", SMALL), find_controller(controller), [7], "kinematic")
    loop.run(ticks)
    return loop.world.robots["pose"].copy()


@pytest.mark.parametrize("discrete", [False, True])
def test_a_network_in_onnx_is_a_controller(discrete, file, monkeypatch):
    keywords = {"discrete": discrete, "decision_period": 5}
    env = parallel_env("es1", **SMALL, **keywords)
    path, weights = file(len(env.observation_layout), 5 if discrete else 2)
    save_policy_card(path, "es1", **SMALL, **keywords)
    import onnxruntime

    opened = onnxruntime.InferenceSession

    def opened_in_one_thread(path, options, **terms):
        assert (options.intra_op_num_threads, options.inter_op_num_threads) == (1, 1)
        return opened(path, options, **terms)

    monkeypatch.setattr(onnxruntime, "InferenceSession", opened_in_one_thread)

    def predict(observed):
        given = observed @ weights
        return given.argmax(1) if discrete else np.clip(given, -1.0, 1.0)

    own = poses(f"onnx:{path}", 50)
    np.testing.assert_allclose(own, poses(policy_controller(predict, **keywords), 50), atol=1e-4)
    assert_array_equal(own, poses(f"onnx:{path}", 50))
    assert not np.allclose(own, poses("ssgikf", 50), atol=1e-2)


def test_a_network_that_does_not_fit_and_a_file_that_is_none_are_refused(file):
    def refused(path, says):
        with pytest.raises(ConfigError, match=says):
            find_controller(f"onnx:{path}").check_usable(find_scenario("es1", SMALL))

    path, _ = file(3, 2)
    refused(path, r"p.onnx: does not accept observations of 4 robots and \d\d+ features \(")
    file(3, 2, ["seen", "more"])
    refused(path, "p.onnx: has inputs seen, more; must have one")
    path.write_text("no network")
    refused(path, r"p\.onnx: is not ONNX \(")


def test_without_the_package_one_line_says_what_installs_it(tmp_path, monkeypatch):
    (tmp_path / "p.onnx").write_text("")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    controller = find_controller(f"onnx:{tmp_path / 'p.onnx'}")
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'swarm-forage\[onnx\]'$") as error:
        controller.check_usable(find_scenario("es1"))
    assert error.value.name == "onnxruntime"


class Network(torch.nn.Module):
    """A network in TorchScript that gives what it was made with."""

    def __init__(self, given):
        super().__init__()
        self.given = torch.nn.Parameter(torch.tensor(given), requires_grad=False)

    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        if seen.shape[1] != 4:
            raise RuntimeError("an odd number")
        return self.given


@pytest.mark.parametrize(
    ("space", "given", "acts"),
    [
        (Discrete(3), [[0.0, 1.0, 0.5], [3.0, 1.0, 2.0]], [1, 0]), (Discrete(3), [2, 0], [2, 0]),
        (Box(-1.0, 1.0, (2,)), [[0.0, 1.0], [3.0, 1.0]], [[0.0, 1.0], [3.0, 1.0]]),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:`torch.jit")
def test_a_network_in_torchscript_tells_choices_by_number_or_by_score(
    tmp_path, monkeypatch, space, given, acts
):
    torch.jit.script(Network(given)).save(str(tmp_path / "p.pt"))
    form = SimpleNamespace(action_space=space, layout=[0] * 4)
    act = TorchScriptPolicy(file=str(tmp_path / "p.pt")).start(form).act
    threads = []
    monkeypatch.setattr(torch, "set_num_threads", threads.append)
    assert act(np.zeros((2, 4), np.float32), None, None)[0].tolist() == acts
    assert threads == [1, torch.get_num_threads()]
    with pytest.raises(
        ConfigError, match=r"observations of 2 robots and 3 features \(.*an odd number\); give"
    ) as no:
        act(np.zeros((2, 3), np.float32), None, None)
    assert "\n" not in str(no.value)
    (tmp_path / "p.pt").write_text("no network")
    with pytest.raises(ConfigError, match=r"is not TorchScript \(\w[^\n]*\)$"):
        TorchScriptPolicy(file=str(tmp_path / "p.pt")).start(form)
