"""Policies of stable-baselines3, from what `model.save("model.zip")` writes.

Of a zip the weights are read, by torch's loader of weights, and what it holds as plain JSON.
Nothing is unpickled unless `trust=true` asks for it: a pickle runs whatever code it holds.
"""

import io
import json
import re
from collections.abc import Callable, Mapping
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from gymnasium.spaces import Box, Discrete
from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError, field_validator

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Count, Part
from training.foreign_file import (
    LARGEST,
    LARGEST_CARD,
    LARGEST_TELLING,
    LARGEST_ZIP,
    check_file,
    check_zip,
    is_file,
    read_members,
    reason,
)
from training.policy import Draw, PolicyFile, Predict, drawn_choices
from training.policy_card import PolicyCard, card_from
from training.policy_file import check_weights, misfit

if TYPE_CHECKING:
    from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
    from stable_baselines3.sac.policies import SACPolicy
    from torch import Tensor

PICKLED = ":serialized:"
"""Key of what stable-baselines3 keeps as a pickle, within its JSON."""

NO_MATTER = (PICKLED, ":type:", "optimizer_class", "optimizer_kwargs")
"""What makes no difference to a policy that is not trained on."""

ACTIVATION = re.compile(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>")

Widths = Annotated[list[Count], Field(max_length=100)]
"""Numbers of units of the hidden layers."""

Branches = dict[Literal["pi", "vf", "qf"], Widths]
"""Hidden layers of the actor, and of the critic."""


class Told(BaseModel):
    """What is read of a larger whole."""

    model_config = ConfigDict(frozen=True)


class Space(Told):
    """A space of observations or actions."""

    n: int | None = None
    """How many choices there are."""
    shape: tuple[int, ...] | None = Field(None, alias="_shape", max_length=100)
    policy_card: Annotated[str, Field(max_length=LARGEST_CARD)] | None = None
    """The card of the policy as JSON, on the space of observations."""

    @property
    def size(self) -> str:
        """Its numbers or choices, in words."""
        if self.n is not None:
            return f"one of {self.n} choices"
        return "x".join(map(str, self.shape or ["no"]))


class ClassTold(Told):
    """A class, as JSON tells of it beside its pickle."""

    module: str = Field("", alias="__module__")
    init: str = Field("", alias="__init__")


class SavedModel(Told):
    """What the JSON of a zip tells of a model."""

    policy_class: ClassTold
    policy_kwargs: Annotated[dict[str, JsonValue], Field(max_length=50)]
    observation_space: Space = Space()
    action_space: Space = Space()
    use_sde: bool = False


class Network(Part):
    """The keywords of a policy that need no pickle."""

    net_arch: Widths | Branches | Annotated[list[Branches], Field(max_length=1)] | None = None
    activation_fn: type[object] | None = None
    n_critics: Annotated[int, Field(ge=1, le=100)] | None = None
    ortho_init: bool = True
    use_sde: bool = False
    log_std_init: float = 0.0
    full_std: bool = True
    use_expln: bool = False
    clip_mean: float = 0.0
    squash_output: bool = False
    share_features_extractor: bool = True
    normalize_images: bool = True

    @field_validator("activation_fn", mode="before")
    @classmethod
    def _of_torch(cls, told: object) -> type[object]:
        from torch.nn.modules import activation

        named = ACTIVATION.fullmatch(str(told))
        if named is None or named[1] not in activation.__all__:
            raise ValueError("must be an activation of torch.nn")
        found: type[object] = vars(activation)[named[1]]
        return found

    def n_weights(self, n_observed: int) -> int:
        """The weights of one of its networks up to the last hidden layer, times its critics."""
        arch = self.net_arch or []
        parts = [arch] if isinstance(arch, dict) else arch
        branches = [each for part in parts if isinstance(part, dict) for each in part.values()]
        shared = [part for part in parts if isinstance(part, int)]
        chains = ([n_observed, *each] for each in (shared, *branches))
        return (self.n_critics or 1) * max(sum(a * b for a, b in pairwise(c)) for c in chains)


def read_zip(file: Path) -> tuple[SavedModel, bytes, bytes]:
    """What a model's zip tells of it, the same as JSON, and its weights; ConfigError for another
    file."""
    check_file(file, "policy", LARGEST_ZIP)
    try:
        data, weights = read_members(file, {"data": LARGEST_TELLING, "policy.pth": LARGEST})
        return SavedModel.model_validate_json(data), data, weights
    except ValueError as error:
        raise ConfigError(
            f"policy {file}: must be what stable-baselines3's model.save() writes ({reason(error)})"
        ) from None


def network_of(file: str, model: SavedModel, n_observed: int, n_bytes: int) -> Network | None:
    """The keywords of the policy; None if some are told by a pickle only.

    ConfigError for others, and for a network of more weights than its file has bytes for.
    """
    told = {name: each for name, each in model.policy_kwargs.items() if name not in NO_MATTER}
    if any(_is_pickled(each) for each in told.values()):
        return None
    try:
        network = Network.model_validate(told)
    except ValidationError as error:
        raise ConfigError(
            f"policy {file}: cannot be made here: policy_kwargs.{reason(error)}"
        ) from None
    if 4 * network.n_weights(n_observed) > n_bytes:
        raise ConfigError(
            f"policy {file}: its weights do not fit: net_arch asks for"
            f" {network.n_weights(n_observed):.3g} of them at least, in {n_bytes} bytes"
        )
    return network


def read_weights(file: str, content: bytes) -> Mapping[str, "Tensor"]:
    """The weights of a policy; ConfigError for what torch's loader of weights does not take."""
    import torch

    try:
        check_zip(content)
        found = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
        if not isinstance(found, Mapping) or not all(
            isinstance(name, str) and isinstance(each, torch.Tensor) for name, each in found.items()
        ):
            raise ValueError("they are no arrays by name")
    except Exception as error:  # what is no pickle raises anything
        raise ConfigError(f"policy {file}: its weights cannot be read ({reason(error)})") from None
    return found


def _is_pickled(told: object) -> bool:
    return isinstance(told, str) and told.startswith("<") and not ACTIVATION.fullmatch(told)


KNOWN = {
    "stable_baselines3.common.policies": "ActorCriticPolicy",
    "stable_baselines3.dqn.policies": "DQNPolicy",
    "stable_baselines3.sac.policies": "SACPolicy",
    "stable_baselines3.td3.policies": "TD3Policy",
}
"""Classes of policies that need no pickle: of PPO and A2C, DQN, SAC, TD3 and DDPG."""

Chosen = tuple[type["BasePolicy"], dict[str, Any]]
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
        """The model's policy, without chance."""
        model = self._model(form)
        return self._asked(lambda observed: model.predict(observed, deterministic=True)[0])

    def start_by_chance(self, form: PolicyForm) -> Draw:
        """The model's policy, from the distribution of its actions; ConfigError without one."""
        import torch
        from stable_baselines3.common.policies import ActorCriticPolicy
        from stable_baselines3.sac.policies import SACPolicy
        from torch.distributions import Categorical

        model = self._model(form)
        if not isinstance(model, ActorCriticPolicy | SACPolicy):
            return super().start_by_chance(form)

        @torch.no_grad()
        def by_chance(observed: Array, draws: Array) -> Array:
            found = _distribution(model, torch.as_tensor(observed))
            if isinstance(found, Categorical):
                return drawn_choices(found.probs.double().numpy(), draws)
            actions = (found.mean + found.stddev * torch.as_tensor(draws)).float().numpy()
            return model.unscale_action(np.tanh(actions)) if model.squash_output else actions

        return self._asked(by_chance)

    def _model(self, form: PolicyForm) -> "BasePolicy":
        """The model's policy, with its weights."""
        told, data, content = read_zip(self.path)
        _check_spaces(self.file, told, form)
        chosen = self._trusted(data) if self.trust else self._plain(told, form, len(content))
        if told.use_sde:
            chosen[1].setdefault("use_sde", True)
        model = _make(self.file, chosen, form)
        _load(self.file, model, read_weights(self.file, content))
        return model

    def _asked(self, ask: Callable[..., Any]) -> Callable[..., Array]:
        """The same function; ConfigError where it fails."""

        def asked(*given: Array) -> Array:
            try:
                return np.asarray(ask(*given))
            except (RuntimeError, ValueError) as error:  # of a deviation of 0, as an example
                raise ConfigError(
                    f"policy {self.file}: gives no action ({reason(error)})"
                ) from None

        return asked

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


def _distribution(model: "ActorCriticPolicy | SACPolicy", observed: "Tensor") -> Any:  # noqa: ANN401 of torch
    """The distribution of the actions, before they are squashed."""
    from stable_baselines3.common.policies import ActorCriticPolicy
    from torch.distributions import Normal

    if isinstance(model, ActorCriticPolicy):
        return model.get_distribution(observed).distribution
    mean, log_std, _ = model.actor.get_action_dist_params(observed)
    return Normal(mean, log_std.exp())


def _named_class(told: ClassTold) -> "type[BasePolicy] | None":
    """The class of the policy, by what the JSON tells of it; None for one that is not known."""
    name = KNOWN.get(told.module, "")
    if not name or f"{name}.__init__ " not in told.init:
        return None
    found: type[BasePolicy] = getattr(import_module(told.module), name)
    return found


def _make(file: str, chosen: Chosen, form: PolicyForm) -> "BasePolicy":
    """The policy with random weights."""
    policy, keywords = chosen
    try:
        return policy(form.observation_space, form.action_space, lambda _: 0.0, **keywords)
    except (TypeError, AssertionError, RuntimeError, ValueError) as error:
        raise ConfigError(f"policy {file}: cannot be made here: {reason(error)}") from None


def _load(file: str, model: "BasePolicy", weights: Mapping[str, "Tensor"]) -> None:
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


def _size_of(space: "Box | Discrete[np.int64]") -> str:
    if isinstance(space, Discrete):
        return f"one of {space.n} choices"
    return "x".join(map(str, space.shape))
