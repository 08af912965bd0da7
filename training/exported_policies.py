"""Policies exported by trainers of other libraries: TorchScript, ONNX, or a Python function.

    torch.jit.script(network).save("policy.pt")
    torch.onnx.export(network, (observations,), "policy.onnx", dynamic_shapes=({0: "robots"},))
    save_policy_card("policy.onnx", "es1", learn="motion", decision_period=5)

A network has one input: observations (robots, features), for any number of robots. Its output, in
ONNX the first one, is deterministic actions (robots, actions). Discrete actions are integers
(robots,) or scores of all choices (robots, choices).
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
from swarm_forage_env.interface import files_read_by
from training.foreign_file import check_file, check_zip, reason
from training.policy import PolicyFile, Started, StateSize, imported, module_file, started_function
from training.policy_card import PolicyCard
from training.policy_file import in_one_thread, needed_by


class _Exported(PolicyFile):
    """Base of policies whose network is in a file."""

    def start(self, form: PolicyForm) -> Started:
        """Start the network; from scores of choices, it takes the choice with the highest score."""
        run = self._opened()

        def predict(observed: Array) -> Array:
            try:
                output = run(observed)
            except Exception as error:  # onnxruntime's errors have no other base
                why = reason(ValueError(str(error).strip().rpartition("\n")[2]))
                raise ConfigError(
                    f"policy {self.file}: does not accept observations of {len(observed)} robots"
                    f" and {observed.shape[1]} features ({why}); give the keywords of its"
                    " training, as in normalise=false"
                ) from None
            is_scores = isinstance(form.action_space, Discrete) and output.ndim == 2
            return np.asarray(output.argmax(1) if is_scores else output)

        return started_function(predict, 0, self.source)

    def _opened(self) -> Callable[[Array], Array]:
        """Return the map from observations to outputs. ConfigError for a file of another kind."""
        raise NotImplementedError


class TorchScriptPolicy(_Exported):
    """A network that torch.jit has saved: torchscript:policy.pt."""

    def _opened(self) -> Callable[[Array], Array]:
        import torch

        path = self.path
        check_file(path, "policy")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "`torch.jit")  # torch prefers its newer export
            try:
                check_zip(path)
                network = torch.jit.load(str(path), map_location="cpu").eval()  # type: ignore[no-untyped-call]
            except (RuntimeError, ValueError) as error:
                why = reason(error)
                raise ConfigError(f"policy {self.file}: is not TorchScript ({why})") from None

        @torch.no_grad()
        @in_one_thread()
        def run(observed: Array) -> Array:
            output: Array = network(torch.from_numpy(observed)).numpy()
            return output

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
        options.log_severity_level = 4  # else it logs every error, which is also raised
        on_cpu = ["CPUExecutionProvider"]
        try:
            session = onnxruntime.InferenceSession(str(path), options, providers=on_cpu)
        except Exception as error:  # as above
            raise ConfigError(f"policy {self.file}: is not ONNX ({reason(error)})") from None
        inputs = [each.name for each in session.get_inputs()]
        if len(inputs) != 1:
            raise ConfigError(
                f"policy {self.file}: has inputs {', '.join(inputs)}; must have one, observations"
            )
        return lambda observed: np.asarray(session.run(None, {inputs[0]: observed})[0])


class CallablePolicy(PolicyFile):
    """A Python function: callable:package.module:function.

    It maps observations (robots, features) to actions (robots, actions); with `n_state` also
    hidden states (robots, n_state) to the next ones. Its module is imported, and thereby run, from
    Python's path or the current folder.
    """

    n_state: StateSize = Field(0, description="Size of the hidden state of a robot; 0: none")

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files that the output depends on: that of the module, and those in `function.reads`."""
        function = self._function()
        own = map(Path, files_read_by(function))
        return (*super(PolicyFile, self).reads, module_file(function), *own)

    def card(self) -> PolicyCard | None:
        """Return None: a function has no card; its name gives the keywords."""
        return None

    def start(self, form: PolicyForm) -> Started:
        """Start the function."""
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
            raise ConfigError(f"callable '{self.file}': is a {kind}, not a function")
        return function
