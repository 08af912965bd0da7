"""Policies that a trainer of another library has exported: TorchScript, ONNX, a function by name.

    torch.jit.script(network).save("policy.pt")
    torch.onnx.export(network, (observations,), "policy.onnx", dynamic_shapes=({0: "robots"},))
    save_policy_card("policy.onnx", "es1", learn="motion", decision_period=5)

A network has one input, observations (robots, numbers), any number of robots at once. Its output,
in ONNX the first one, is deterministic actions: (robots, numbers), or whole numbers (robots,) or
scores of all choices (robots, choices) where actions are discrete.
"""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from gymnasium.spaces import Discrete
from pydantic import Field

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.foreign_file import check_file, check_zip, reason
from training.policy import PolicyFile, Started, StateSize, imported, module_file, started_function
from training.policy_card import PolicyCard
from training.policy_file import needed_by


class _Exported(PolicyFile):
    """A network in a file, and the code that runs it."""

    def start(self, form: PolicyForm) -> Started:
        """The network; of scores of choices the choices of the highest ones."""
        run = self._opened()

        def predict(observed: Array) -> Array:
            try:
                output = run(observed)
            except Exception as error:  # those of onnxruntime have no other base
                why = reason(ValueError(str(error).strip().rpartition("\n")[2]))
                raise ConfigError(
                    f"policy {self.file}: does not take observations of {len(observed)} robots and"
                    f" {observed.shape[1]} numbers ({why}); say what it was trained with, as in"
                    " normalise=false"
                ) from None
            is_scores = isinstance(form.action_space, Discrete) and output.ndim == 2
            return np.asarray(output.argmax(1) if is_scores else output)

        return started_function(predict, 0, self.source)

    def _opened(self) -> Callable[[Array], Array]:
        """What maps observations to outputs; ConfigError for a file of another kind."""
        raise NotImplementedError


class TorchScriptPolicy(_Exported):
    """A network that torch.jit has saved: torchscript:policy.pt."""

    def _opened(self) -> Callable[[Array], Array]:
        import torch

        path = self.path
        check_file(path, "policy")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # torch prefers its newer export
            try:
                check_zip(path)
                network = torch.jit.load(str(path), map_location="cpu").eval()  # type: ignore[no-untyped-call]
            except (RuntimeError, ValueError) as error:
                why = reason(error)
                raise ConfigError(f"policy {self.file}: is no TorchScript ({why})") from None
        run: Callable[[Array], Array] = torch.no_grad()(
            lambda observed: network(torch.from_numpy(observed)).numpy()
        )
        return run


class OnnxPolicy(_Exported):
    """A network in ONNX, run by onnxruntime: onnx:policy.onnx."""

    def _opened(self) -> Callable[[Array], Array]:
        path = self.path
        check_file(path, "policy")
        with needed_by(f"policy {self.file}"):
            import onnxruntime
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4  # it tells everything twice
        on_cpu = ["CPUExecutionProvider"]
        try:
            session = onnxruntime.InferenceSession(str(path), options, providers=on_cpu)
        except Exception as error:  # as above
            raise ConfigError(f"policy {self.file}: is no ONNX ({reason(error)})") from None
        inputs = [each.name for each in session.get_inputs()]
        if len(inputs) != 1:
            raise ConfigError(
                f"policy {self.file}: has inputs {', '.join(inputs)}; must have one, observations"
            )
        return lambda observed: np.asarray(session.run(None, {inputs[0]: observed})[0])


class CallablePolicy(PolicyFile):
    """A function of Python's: callable:package.module:function.

    It maps what the robots of a world observe to their actions, both (robots, numbers); with
    `n_state` also their hidden states to the next ones, (robots, n_state). Its module is imported,
    which runs it, from Python's path or the current folder.
    """

    n_state: StateSize = Field(0, description="Numbers in the hidden state of a robot; 0: none")

    @property
    def reads(self) -> tuple[Path, ...]:
        """The file of the module too."""
        return (*super(PolicyFile, self).reads, module_file(self._function()))

    def card(self) -> PolicyCard | None:
        """A function has none: its name gives the keywords."""
        return None

    def start(self, form: PolicyForm) -> Started:
        """The function."""
        return started_function(self._function(), self.n_state, self.source)

    def _function(self) -> Callable[..., object]:
        if not self.file.partition(":")[2]:
            raise ConfigError(
                f"callable '{self.file}': must be a module and a function, as in"
                " callable:package.module:function"
            )
        try:
            function = imported(self.file)
        except ConfigError as error:
            raise ConfigError(f"callable {error}") from None
        if not callable(function):
            kind = type(function).__name__
            raise ConfigError(f"callable '{self.file}': is a {kind}, no function")
        return function
