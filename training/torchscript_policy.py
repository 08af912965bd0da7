"""Policies as TorchScript, which any trainer that is written in torch can save.

    torch.jit.script(network).save("policy.pt")
    save_policy_card("policy.pt", "es1", learn="motion", decision_period=5)

The network maps observations, (robots, numbers), to deterministic actions: (robots, numbers), or
whole numbers (robots,) or scores of all choices (robots, choices) where actions are discrete.
"""

import warnings
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.foreign_file import check_file, check_zip, reason
from training.policy import PolicyFile, Predict


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
        scores = isinstance(form.action_space, Discrete)

        @torch.no_grad()
        def predict(observed: Array) -> Array:
            try:
                given = network(torch.from_numpy(observed)).numpy()
            except (RuntimeError, torch.jit.Error) as error:  # the latter is raised by a script
                told = str(error).strip().rpartition("\n")[2]
                raise ConfigError(
                    f"policy {self.file}: does not take observations of {len(form.layout)} numbers"
                    f" ({told}); say what it was trained with, as in normalise=false"
                ) from None
            return np.asarray(given.argmax(1) if scores and given.ndim == 2 else given)

        return predict
