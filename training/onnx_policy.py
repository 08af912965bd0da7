"""Policies as ONNX, which trainers of every library can export.

    torch.onnx.export(network, (observations,), "policy.onnx", dynamic_shapes=({0: "robots"},))
    save_policy_card("policy.onnx", "es1", learn="motion", decision_period=5)

The network has one input, observations (robots, numbers), any number of robots at once. Its first
output is deterministic actions: (robots, numbers), or whole numbers (robots,) or scores of all
choices (robots, choices) where actions are discrete.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import remedy
from training.foreign_file import check_file, reason
from training.policy import PolicyFile, Predict


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
        scores = isinstance(form.action_space, Discrete)

        def predict(observed: Array) -> Array:
            try:
                given = np.asarray(session.run(None, {inputs[0]: observed})[0])
            except Exception as error:  # its own classes have no other base
                raise ConfigError(
                    f"policy {self.file}: does not take observations of {observed.shape[0]} robots"
                    f" and {observed.shape[1]} numbers ({reason(error)}); say what it was"
                    " trained with, as in normalise=false"
                ) from None
            return np.asarray(given.argmax(1) if scores and given.ndim == 2 else given)

        return predict

    def _session(self) -> Any:  # noqa: ANN401 of onnxruntime
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
