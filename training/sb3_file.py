"""What the zip of a model of stable-baselines3 holds, read without unpickling anything."""

import io
import re
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError, field_validator

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Count, Part
from training.foreign_file import (
    LARGEST,
    LARGEST_CARD,
    LARGEST_TELLING,
    LARGEST_ZIP,
    check_file,
    check_zip,
    read_members,
    reason,
)

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
    activation_fn: type[Any] | None = None
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
    def _of_torch(cls, told: Any) -> type[Any]:  # noqa: ANN401 JSON
        from torch.nn.modules import activation

        named = ACTIVATION.fullmatch(str(told))
        if named is None or named[1] not in activation.__all__:
            raise ValueError("must be an activation of torch.nn")
        found: type[Any] = vars(activation)[named[1]]
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


def read_weights(file: str, content: bytes) -> Mapping[str, Any]:
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


def _is_pickled(told: Any) -> bool:  # noqa: ANN401 JSON
    return isinstance(told, str) and told.startswith("<") and not ACTIVATION.fullmatch(told)
