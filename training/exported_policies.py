"""Policies that a trainer of another library has exported: TorchScript, ONNX, a function by name.

    torch.jit.script(network).save("policy.pt")
    torch.onnx.export(network, (observations,), "policy.onnx", dynamic_shapes=({0: "robots"},))
    save_policy_card("policy.onnx", "es1", learn="motion", decision_period=5)

A network has one input, observations (robots, numbers), any number of robots at once. Its output,
in ONNX the first one, is deterministic actions: (robots, numbers), or whole numbers (robots,) or
scores of all choices (robots, choices) where actions are discrete.
"""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium.spaces import Discrete

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import remedy
from training.foreign_file import check_file, check_zip, reason
from training.policy import SHOWN_BY, PolicyFile, Predict, imported, module_file
from training.policy_card import PolicyCard

if TYPE_CHECKING:
    from onnxruntime import InferenceSession


class TorchScriptPolicy(PolicyFile):
    """A network that torch.jit has saved: torchscript:policy.pt."""

    def start(self, form: PolicyForm) -> Predict:
        """The network."""
        import torch

        path = self.path
        check_file(path, "policy")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # torch prefers its newer export
            try:
                check_zip(path)
                load: Any = torch.jit.load
                network = load(str(path), map_location="cpu").eval()
            except (RuntimeError, ValueError) as error:
                raise ConfigError(
                    f"policy {self.file}: is no TorchScript ({reason(error)})"
                ) from None

        @torch.no_grad()
        def predict(observed: Array) -> Array:
            try:
                given = network(torch.from_numpy(observed)).numpy()
            except (RuntimeError, torch.jit.Error) as error:  # the latter is raised by a script
                told = str(error).strip().rpartition("\n")[2]
                raise _unfit(self.file, f"{len(form.layout)} numbers", told) from None
            return _chosen(given, form)

        return predict


class OnnxPolicy(PolicyFile):
    """A network in ONNX, run by onnxruntime: onnx:policy.onnx."""

    def start(self, form: PolicyForm) -> Predict:
        """The network, on one thread."""
        session = self._session()
        inputs = [each.name for each in session.get_inputs()]
        if len(inputs) != 1:
            raise ConfigError(
                f"policy {self.file}: has inputs {', '.join(inputs)}; must have one, observations"
            )

        def predict(observed: Array) -> Array:
            try:
                given = np.asarray(session.run(None, {inputs[0]: observed})[0])
            except Exception as error:  # its own classes have no other base
                size = f"{observed.shape[0]} robots and {observed.shape[1]} numbers"
                raise _unfit(self.file, size, reason(error)) from None
            return _chosen(given, form)

        return predict

    def _session(self) -> "InferenceSession":
        path = self.path
        check_file(path, "policy")
        try:
            import onnxruntime
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(
                f"policy {self.file}: needs '{error.name}': {remedy(error.name)}", name=error.name
            ) from None
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4  # it tells everything twice
        try:
            return onnxruntime.InferenceSession(
                str(path), options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # as above
            raise ConfigError(f"policy {self.file}: is no ONNX ({reason(error)})") from None


class CallablePolicy(PolicyFile):
    """A function of Python's: callable:package.module:function.

    It maps what the robots of a world observe to their actions, both (robots, numbers). Its module
    is looked for on Python's path, and in the current folder. Importing it runs it.
    """

    @property
    def reads(self) -> tuple[Path, ...]:
        """The file of the module too."""
        return (*SHOWN_BY, module_file(self._function()))

    def card(self) -> PolicyCard | None:
        """A function has none: its name says what it goes with."""
        return None

    def start(self, form: PolicyForm) -> Predict:
        """The function."""
        return self._function()

    def _function(self) -> Predict:
        if not self.file.partition(":")[2]:
            raise ConfigError(
                f"callable '{self.file}': must be a module and a function, as in"
                " callable:package.module:function"
            )
        try:
            found: Predict = imported(self.file)
        except ConfigError as error:
            raise ConfigError(f"callable {error}") from None
        if not callable(found):
            raise ConfigError(f"callable '{self.file}': is a {type(found).__name__}, no function")
        return found


def _chosen(given: Array, form: PolicyForm) -> Array:
    """The actions of a network; of scores of choices the choices of the highest ones."""
    scores = isinstance(form.action_space, Discrete) and given.ndim == 2
    return np.asarray(given.argmax(1) if scores else given)


def _unfit(file: str, observed: str, why: str) -> ConfigError:
    return ConfigError(
        f"policy {file}: does not take observations of {observed} ({why}); say what it was trained"
        " with, as in normalise=false"
    )
