"""Policies of stable-baselines3, from what `model.save("model.zip")` writes.

Of a zip the weights are read, by torch's loader of weights, and what it holds as plain JSON.
Nothing is unpickled unless `trust=true` asks for it: a pickle runs whatever code it holds.
"""

import io
import json
import re
import zipfile
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.policy import PolicyFile, Predict
from training.policy_card import ON_SPACE, PolicyCard, card_from

PICKLED = ":serialized:"
"""Key of what stable-baselines3 keeps as a pickle, within its JSON."""

NO_MATTER = (PICKLED, ":type:", "optimizer_class", "optimizer_kwargs")
"""What makes no difference to a policy that is not trained on."""

ACTIVATION = re.compile(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>")

KNOWN = {
    "stable_baselines3.common.policies": "ActorCriticPolicy",
    "stable_baselines3.dqn.policies": "DQNPolicy",
    "stable_baselines3.sac.policies": "SACPolicy",
    "stable_baselines3.td3.policies": "TD3Policy",
}
"""Classes of policies that need no pickle: of PPO and A2C, DQN, SAC, TD3 and DDPG."""


class SB3Policy(PolicyFile):
    """A model that stable-baselines3 has saved: sb3:model.zip."""

    trust: bool = Field(False, description="Unpickle what the file holds: runs any code in it")

    @property
    def path(self) -> Path:
        """The file, with or without its ending."""
        if self.file and not Path(self.file).suffix and Path(f"{self.file}.zip").is_file():
            return Path(f"{self.file}.zip")
        return super().path

    def card(self) -> PolicyCard | None:
        """The card on the observation space that the model was trained with."""
        space = read_zip(self.path)[0].get("observation_space")
        if isinstance(space, Mapping) and ON_SPACE in space:
            return card_from(space[ON_SPACE], f"in {self.file}")
        return super().card()

    def start(self, form: PolicyForm) -> Predict:
        """The model's policy, with its weights."""
        data, content = read_zip(self.path)
        _check_spaces(self.file, data, form)
        model = _make(self.file, self._chosen(data), form)
        weights = _read_weights(self.file, content)
        try:
            model.load_state_dict(weights)
        except (RuntimeError, TypeError) as error:
            raise ConfigError(f"policy {self.file}: its weights do not fit: {error}") from None

        def predict(observed: Array) -> Array:
            return np.asarray(model.predict(observed, deterministic=True)[0])

        return predict

    def _chosen(self, data: Mapping[str, Any]) -> tuple[type[Any], dict[str, Any]]:
        """The class of the policy, and its keywords."""
        if self.trust:
            from stable_baselines3.common.save_util import json_to_data

            wanted = {name: data[name] for name in ("policy_class", "policy_kwargs")}
            found = json_to_data(json.dumps(wanted))
            return found["policy_class"], _with_sde(found["policy_kwargs"], data)
        policy, keywords = _named_class(data["policy_class"]), _plain(data["policy_kwargs"])
        if policy is None or keywords is None:
            what = "policy_class" if policy is None else "policy_kwargs"
            raise ConfigError(
                f"policy {self.file}: its {what} can only be had by unpickling, which runs whatever"
                f" code is in the file; where you trust it: sb3:{self.file},trust=true"
            )
        return policy, _with_sde(keywords, data)


def read_zip(file: Path) -> tuple[dict[str, Any], bytes]:
    """What a model's zip holds as JSON, and its weights; ConfigError for another file."""
    try:
        with zipfile.ZipFile(file) as archive:
            data: dict[str, Any] = json.loads(archive.read("data"))
            return data, archive.read("policy.pth")
    except (zipfile.BadZipFile, KeyError, ValueError) as error:
        raise ConfigError(
            f"policy {file}: must be what stable-baselines3's model.save() writes ({error})"
        ) from None


def _read_weights(file: str, content: bytes) -> dict[str, Any]:
    """The weights of a policy; ConfigError for what torch's loader of weights does not take."""
    import torch

    try:
        found: dict[str, Any] = torch.load(
            io.BytesIO(content), map_location="cpu", weights_only=True
        )
    except Exception as error:  # what is no pickle raises anything
        told = str(error).partition("\n")[0] or "it is empty"
        raise ConfigError(f"policy {file}: its weights cannot be read ({told})") from None
    return found


def _named_class(told: Any) -> type[Any] | None:  # noqa: ANN401 JSON
    """The class of the policy, by what the JSON tells of it; None for one that is not known."""
    home = told.get("__module__", "") if isinstance(told, Mapping) else ""
    name = KNOWN.get(home, "")
    if not name or f"{name}.__init__ " not in str(told.get("__init__", "")):
        return None
    found: type[Any] = getattr(import_module(home), name)
    return found


def _plain(keywords: Mapping[str, Any]) -> dict[str, Any] | None:
    """The keywords of the policy; None if some are told by a pickle only."""
    if PICKLED not in keywords:
        return dict(keywords)
    from torch import nn

    found = {name: value for name, value in keywords.items() if name not in NO_MATTER}
    for name, value in found.items():
        activation = ACTIVATION.fullmatch(str(value))
        if activation:
            found[name] = getattr(nn, activation[1])
        elif str(value).startswith("<"):
            return None
    return found


def _with_sde(keywords: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """The keywords of the policy, and what the algorithm hands it beside them."""
    sde = {"use_sde": True} if data.get("use_sde") else {}
    return {**sde, **keywords}


def _make(file: str, chosen: tuple[type[Any], dict[str, Any]], form: PolicyForm) -> Any:  # noqa: ANN401 a policy
    """The policy with random weights."""
    policy, keywords = chosen
    try:
        return policy(form.observation_space, form.action_space, lambda _: 0.0, **keywords)
    except (TypeError, AssertionError) as error:
        raise ConfigError(f"policy {file}: cannot be made here: {error}") from None


def _check_spaces(file: str, data: Mapping[str, Any], form: PolicyForm) -> None:
    """ConfigError if the model was trained on observations or actions of other shapes."""
    trained = tuple(_size(data.get(f"{kind}_space")) for kind in ("observation", "action"))
    here = str(len(form.layout)), _size_of(form.action_space)
    if trained != here:
        raise ConfigError(
            f"policy {file}: maps {trained[0]} numbers to {trained[1]}; under these keywords"
            f" (learn={form.config.learn}) there are {here[0]}, and {here[1]}. Say what it was"
            f" trained with, as in sb3:{file},normalise=false,action=wheels"
        )


def _size(space: Any) -> str:  # noqa: ANN401 JSON
    """Numbers or choices of a space, from its JSON."""
    if not isinstance(space, Mapping):
        return "no"
    if "n" in space:
        return f"one of {space['n']} choices"
    return "x".join(map(str, space.get("_shape") or ["no"]))


def _size_of(space: Any) -> str:  # noqa: ANN401 a Box or Discrete
    return f"one of {space.n} choices" if hasattr(space, "n") else "x".join(map(str, space.shape))
