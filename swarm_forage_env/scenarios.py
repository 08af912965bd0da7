"""Scenarios by name or from a file, with single parameters changed."""

import tomllib
from collections.abc import Mapping
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast, overload

from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.parameters import BaseScenario, leaves, override
from swarm_forage_env.registry import CONTROLLERS, SCENARIOS
from swarm_forage_env.task import task_of

if TYPE_CHECKING:
    from swarm_forage_env.aggregation import AggregationScenario
    from swarm_forage_env.foraging.scenario import Scenario
    from swarm_forage_env.waypoints.scenario import WaypointsScenario

ForagingName = Literal[
    "ants2008", "es1", "es1-clean", "es2", "es3", "mg1-dodecagon", "mg1-hexagon", "mg1-square",
    "moving-prey", "near", "real", "two-nests", "two-prey",
]  # fmt: skip
WaypointsName = Literal[
    "waypoints-05", "waypoints-10", "waypoints-25", "waypoints-50", "waypoints-05-authors",
    "waypoints-10-authors", "waypoints-25-authors", "waypoints-50-authors",
]  # fmt: skip

ScenarioSource = ForagingName | WaypointsName | Literal["aggregation"] | str | Path | BaseScenario
"""A name, a TOML file or a scenario; an editor completes the names."""

Overrides = Mapping[str, object] | None

ScenarioT = TypeVar("ScenarioT", bound=BaseScenario)


@overload
def find_scenario(scenario: ForagingName, overrides: Overrides = None) -> "Scenario": ...
@overload
def find_scenario(scenario: WaypointsName, overrides: Overrides = None) -> "WaypointsScenario": ...
@overload
def find_scenario(
    scenario: Literal["aggregation"], overrides: Overrides = None
) -> "AggregationScenario": ...
@overload
def find_scenario(scenario: ScenarioT, overrides: Overrides = None) -> ScenarioT: ...
@overload
def find_scenario(scenario: ScenarioSource, overrides: Overrides = None) -> Any: ...  # noqa: ANN401 of any task
def find_scenario(scenario: ScenarioSource, overrides: Overrides = None) -> Any:
    """Return the scenario of a name (`es1`), a TOML file (`mine.toml`) or a scenario, overridden.

    Overrides have dotted names: {"radio.max_range": 0.2}. UnknownNameError for an unknown name,
    ConfigError for a value that does not fit and for an invalid file.

    >>> find_scenario("es1", {"task.n_robots": 20}).task.n_robots
    20

    Args:
        scenario: A name, a TOML file, or a scenario.
        overrides: Parameters to change, by dotted name, or by the last part where it is unique.
    """
    if isinstance(scenario, str | Path):
        is_file = str(scenario).endswith(".toml")
        scenario = from_toml(Path(scenario)) if is_file else _named(str(scenario))
    task_of(scenario)
    return override(scenario, overrides or {}, "scenario parameter")


def _named(name: str) -> BaseScenario:
    """Return the scenario of a name; ConfigError for a controller, another file or parameters, and
    for a scenario that has another name in it."""
    if name not in SCENARIOS and Path(name).suffix and isfile(name):
        raise ConfigError(f"scenario file {name}: must be TOML, under a name that ends in .toml")
    if name not in SCENARIOS and name.partition(":")[0] in CONTROLLERS:
        raise ConfigError(
            f"no scenario named {name!r}: it is a controller, and the scenario comes first, as in"
            f" `es1 {name}`"
        )
    if name not in SCENARIOS and name.partition(":")[0] in SCENARIOS:
        raise ConfigError(
            f"scenario '{name}': its parameters are given apart: --set task.n_robots=3 in a"
            " command, keywords in Python"
        )
    scenario: Any = SCENARIOS[name]
    registered = SCENARIOS.name_of(scenario)
    if isinstance(scenario, BaseScenario) and scenario.name != registered:
        raise ConfigError(
            f"scenario '{registered}': its results would be those of '{scenario.name}', the name"
            f" in it; register it with name='{registered}'"
        )
    return cast(BaseScenario, scenario)


def from_toml(file: Path) -> BaseScenario:
    """Return the scenario of a TOML file, which has a table for each part, such as robot.

    `base = "es1"` at its top names the scenario from which all other parameters are taken.
    """
    try:
        changes = leaves(tomllib.loads(file.read_text(encoding="utf-8")))
    except OSError as error:
        raise ConfigError(f"scenario file {file}: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"scenario file {file}: {error}") from None
    except RecursionError:
        raise ConfigError(
            f"scenario file {file}: its tables are nested too deeply; a parameter of a scenario"
            " is in one table, as max_range in [radio]"
        ) from None
    if "base" not in changes:
        raise ConfigError(
            f'scenario file {file}: has no base; write base = "es1" at its top, or another'
            " scenario, for the parameters that the file does not set"
        )
    base = changes.pop("base")
    if not isinstance(base, str) or base.endswith(".toml"):
        raise ConfigError(
            f"scenario file {file}: base={base!r}: must be the name of a scenario, such as es1,"
            " not a file"
        )
    try:
        known: BaseScenario = SCENARIOS[base]
        return override(known, {"name": file.stem, **changes}, "scenario parameter")
    except (ConfigError, UnknownNameError) as error:
        raise ConfigError(f"scenario file {file}: {error}") from None
