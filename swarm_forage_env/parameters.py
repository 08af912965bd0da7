"""Parameters: frozen, validated models, and functions that change single fields of them."""

import json
from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from swarm_forage_env.errors import ConfigError, UnknownNameError, shown

LARGEST = 1e12
"""Upper bound of numbers without another one: their cubes are finite in double precision."""


def _at_most_the_largest(value: float) -> float:
    """Refuse a number above `LARGEST`; a bound `le` in the type would hide that of a field."""
    if value > LARGEST:
        raise PydanticCustomError("too_large", f"Input should be at most {LARGEST:g}")
    return value


Positive = Annotated[float, Field(gt=0.0), AfterValidator(_at_most_the_largest)]
NotNegative = Annotated[float, Field(ge=0.0), AfterValidator(_at_most_the_largest)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1)]

PartT = TypeVar("PartT", bound="Parameters")
ValueT = TypeVar("ValueT")


MIN_TICK = 1e-3
"""Shortest control period [s]."""

MAX_TICKS = 10**9
"""Longest episode [ticks]."""


class Parameters(BaseModel):
    """A frozen group of parameters that refuses unknown fields, NaN and infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def list_as(example: str) -> Callable[[Any, ValidationInfo], Any]:
    """Return a validator of lists given as text on a command line; ValueError if not JSON."""

    def from_text(value: Any, info: ValidationInfo) -> Any:  # noqa: ANN401 whatever was given
        if not isinstance(value, str):
            return value
        try:
            return json.loads(value if value.lstrip().startswith("[") else f"[{value}]")
        except json.JSONDecodeError:
            name = info.field_name
            raise ValueError(f"{name}={value}: must be a list in JSON, such as {example}") from None

    return from_text


class BaseTask(Parameters):
    """Base class of the part `task` of a scenario."""

    if TYPE_CHECKING:
        n_robots: int = 1
        duration: float = 1.0


EpisodeT_co = TypeVar("EpisodeT_co", covariant=True)


class HasEpisodes(Protocol[EpisodeT_co]):
    """Protocol of a scenario for type checkers: it determines the class of its episodes."""

    @property
    def _episode(self) -> type[EpisodeT_co]:
        """Class of its episodes."""


class BaseScenario(Parameters):
    """Base class of scenarios: subclasses have the fields `name`, `tick` [s] and `task`."""

    if TYPE_CHECKING:
        name: str = ""
        tick: float = 1.0
        task: BaseTask = BaseTask()
        _episode: type[Any]  # the class in `Task.episode`

    fixed: ClassVar[tuple[str, ...]] = ("task.n_robots",)
    """Parameters that determine the sizes of records: they are constant for a world."""

    @model_validator(mode="after")
    def _lasts(self) -> Self:
        duration, tick = self.task.duration, self.tick
        if round(duration / tick) < 1:
            raise ValueError(f"task.duration={duration}: must be at least one tick of {tick} s")
        if duration / tick > MAX_TICKS:
            raise ValueError(
                f"task.duration={duration}: must be at most {MAX_TICKS * tick:g} s, {MAX_TICKS}"
                f" ticks of {tick} s"
            )
        return self

    @property
    def n_ticks(self) -> int:
        """Number of ticks in an episode."""
        return round(self.task.duration / self.tick)

    @property
    def unread(self) -> Mapping[str, str]:
        """Parameters that this scenario does not use, each with the one used instead, by name."""
        return {}

    @property
    def falsifying(self) -> tuple[str, ...]:
        """Dotted names of the parameters that falsify messages of robots."""
        return ()


def override(part: PartT, values: Mapping[str, object], kind: str = "parameter") -> PartT:
    """Return the part with some fields changed, each named by its dotted path or, if only one
    field has it, by its last word.

    Values may be text, as on a command line. UnknownNameError for a name that is no field,
    ConfigError for a value that does not fit.

    >>> class Radio(Parameters):
    ...     max_range: Positive = 0.15
    >>> override(Radio(), {"max_range": "0.2"}).max_range
    0.2
    """
    if not values:
        return part
    tree = part.model_dump()
    for path, value in with_full_names(values, leaves(tree), kind).items():
        *branches, leaf = path.split(".")
        node = tree
        for branch in branches:
            node = node[branch]
        node[leaf] = value
    return validated(type(part), tree)


def leaves(tree: Mapping[str, object], prefix: str = "") -> dict[str, Any]:
    """Return every field of a nested mapping by its dotted path."""
    values: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            values |= leaves(value, f"{prefix}{name}.")
        else:
            values[prefix + name] = value
    return values


def numbers_named(part: Parameters, names: Collection[str]) -> dict[str, Any]:
    """Return the fields of a part whose last word is one of these names, by that word.

    Of several such fields it is the first, so that a task may have a `radius` beside the robot's.
    """
    tree = reversed(leaves(part.model_dump()).items())
    words = {path.rpartition(".")[2]: value for path, value in tree}
    return {name: words[name] for name in names if name in words}


def resolve(name: str, paths: Collection[str], kind: str) -> str:
    """Return the full dotted path of a name: itself, or the only path that ends in it."""
    if name in paths:
        return name
    same_leaf = [path for path in paths if path.rpartition(".")[2] == name]
    if len(same_leaf) == 1:
        return same_leaf[0]
    if same_leaf:
        raise ConfigError(f"{kind} '{name}' is ambiguous; write {' or '.join(same_leaf)}")
    raise UnknownNameError(kind, name, paths)


def with_full_names(
    values: Mapping[str, ValueT], paths: Collection[str], kind: str
) -> dict[str, ValueT]:
    """Return the values by their full dotted paths; ConfigError for one that is given twice."""
    names: dict[str, str] = {}
    for name in values:
        path = resolve(name, paths, kind)
        if path in names:
            raise ConfigError(f"{path}: is given twice, as '{names[path]}' and as '{name}'")
        names[path] = name
    return {path: values[name] for path, name in names.items()}


def validated(model: type[PartT], tree: Mapping[str, object], where: str = "") -> PartT:
    """Return the model of a mapping, or raise one ConfigError that names each invalid field."""
    try:
        return model.model_validate(dict(tree))
    except ValidationError as error:
        raise ConfigError("; ".join(_complaint(model, e, where) for e in error.errors())) from None


def _complaint(model: type[Parameters], error: ErrorDetails, where: str) -> str:
    path = ".".join(str(step) for step in error["loc"])
    prefix = f"{where}: " if where else ""
    if error["type"] == "extra_forbidden":
        known = leaves(model.model_construct().model_dump())
        return prefix + str(UnknownNameError("parameter", path, known))
    message = str(error["msg"]).removeprefix("Value error, ").replace("Input should", "must", 1)
    if not path or error["type"] == "value_error":
        return prefix + message
    return f"{prefix}{path}={shown(error['input'])}: {message[0].lower()}{message[1:]}"
