"""Policies of stable-baselines3, from what `model.save("model.zip")` writes.

Of a zip the weights are read, by torch's loader of weights, and what it holds as plain JSON.
Nothing is unpickled unless `trust=true` asks for it: a pickle runs whatever code it holds.
"""

import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.foreign_file import is_file, reason
from training.policy import PolicyFile, Predict
from training.policy_card import PolicyCard, card_from
from training.policy_file import check_weights, misfit
from training.sb3_file import ClassTold, SavedModel, network_of, read_weights, read_zip

KNOWN = {
    "stable_baselines3.common.policies": "ActorCriticPolicy",
    "stable_baselines3.dqn.policies": "DQNPolicy",
    "stable_baselines3.sac.policies": "SACPolicy",
    "stable_baselines3.td3.policies": "TD3Policy",
}
"""Classes of policies that need no pickle: of PPO and A2C, DQN, SAC, TD3 and DDPG."""

Chosen = tuple[type[Any], dict[str, Any]]
"""The class of a policy, and its keywords."""


class SB3Policy(PolicyFile):
    """A model that stable-baselines3 has saved: sb3:model.zip."""

    trust: bool = Field(False, description="Unpickle what the file holds: runs any code in it")

    @property
    def path(self) -> Path:
        """The file, with or without its ending."""
        if self.file and not Path(self.file).suffix and is_file(Path(f"{self.file}.zip")):
            return Path(f"{self.file}.zip")
        return super().path

    def card(self) -> PolicyCard | None:
        """The card on the observation space that the model was trained with."""
        told = read_zip(self.path)[0].observation_space.policy_card
        return super().card() if told is None else card_from(told, f"in {self.file}")

    def start(self, form: PolicyForm) -> Predict:
        """The model's policy, with its weights."""
        told, data, content = read_zip(self.path)
        _check_spaces(self.file, told, form)
        chosen = self._trusted(data) if self.trust else self._plain(told, form, len(content))
        if told.use_sde:
            chosen[1].setdefault("use_sde", True)
        model = _make(self.file, chosen, form)
        _load(self.file, model, read_weights(self.file, content))

        def predict(observed: Array) -> Array:
            try:
                return np.asarray(model.predict(observed, deterministic=True)[0])
            except (RuntimeError, ValueError) as error:  # of a deviation of 0, as an example
                raise ConfigError(
                    f"policy {self.file}: gives no action ({reason(error)})"
                ) from None

        return predict

    def _trusted(self, data: bytes) -> Chosen:
        """What chooses the policy, unpickled."""
        from stable_baselines3.common.save_util import json_to_data

        tree = json.loads(data)
        try:
            found = json_to_data(
                json.dumps({k: tree[k] for k in ("policy_class", "policy_kwargs")})
            )
            return found["policy_class"], dict(found["policy_kwargs"])
        except Exception as error:  # what a pickle runs raises anything
            raise ConfigError(
                f"policy {self.file}: cannot be unpickled ({reason(error)})"
            ) from None

    def _plain(self, told: SavedModel, form: PolicyForm, n_bytes: int) -> Chosen:
        """What chooses the policy, from plain JSON."""
        policy = _named_class(told.policy_class)
        network = network_of(self.file, told, len(form.layout), n_bytes)
        if policy is None or network is None:
            what = "policy_class" if policy is None else "policy_kwargs"
            raise ConfigError(
                f"policy {self.file}: its {what} can only be had by unpickling, which runs whatever"
                f" code is in the file; where you trust it: sb3:{self.file},trust=true"
            )
        return policy, network.model_dump(exclude_unset=True)


def _named_class(told: ClassTold) -> type[Any] | None:
    """The class of the policy, by what the JSON tells of it; None for one that is not known."""
    name = KNOWN.get(told.module, "")
    if not name or f"{name}.__init__ " not in told.init:
        return None
    found: type[Any] = getattr(import_module(told.module), name)
    return found


def _make(file: str, chosen: Chosen, form: PolicyForm) -> Any:  # noqa: ANN401 a policy
    """The policy with random weights."""
    policy, keywords = chosen
    try:
        return policy(form.observation_space, form.action_space, lambda _: 0.0, **keywords)
    except (TypeError, AssertionError, RuntimeError, ValueError) as error:
        raise ConfigError(f"policy {file}: cannot be made here: {reason(error)}") from None


def _load(file: str, model: Any, weights: Mapping[str, Any]) -> None:  # noqa: ANN401 a policy
    """Give a policy its weights; ConfigError for others than it has, NaN and infinity."""
    import torch

    shapes = ({name: tuple(w.shape) for name, w in each.items()}
              for each in (weights, model.state_dict()))  # fmt: skip
    other = misfit(*shapes)
    if other:
        raise ConfigError(f"policy {file}: its weights do not fit: {other}")
    try:
        model.load_state_dict(weights)
    except (RuntimeError, TypeError) as error:
        raise ConfigError(f"policy {file}: its weights do not fit: {reason(error)}") from None
    single = (item for item in model.state_dict().items() if item[1].dtype == torch.float32)
    check_weights({name: each.numpy() for name, each in single}, file)


def _check_spaces(file: str, told: SavedModel, form: PolicyForm) -> None:
    """ConfigError if the model was trained on observations or actions of other shapes."""
    trained = told.observation_space.size, told.action_space.size
    here = str(len(form.layout)), _size_of(form.action_space)
    if trained != here:
        raise ConfigError(
            f"policy {file}: maps {trained[0]} numbers to {trained[1]}; under these keywords"
            f" (learn={form.config.learn}) there are {here[0]}, and {here[1]}. Say what it was"
            f" trained with, as in sb3:{file},normalise=false,action=wheels"
        )


def _size_of(space: Any) -> str:  # noqa: ANN401 a Box or Discrete
    return f"one of {space.n} choices" if hasattr(space, "n") else "x".join(map(str, space.shape))
