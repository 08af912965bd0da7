"""Scenarios by name, from a file, and with single numbers changed."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.registry import SCENARIOS, load_folder
from swarm_forage_env.scenario import Scenario, leaves, override
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario

load_folder(__name__, __path__)


def find_scenario(
    scenario: str | Path | AnyScenario, overrides: Mapping[str, Any] | None = None
) -> AnyScenario:
    """The scenario of a name (`es1`), a TOML file (`mine.toml`), or the given one, overridden.

    Overrides go by dotted name: {"radio.max_range": 0.2}. UnknownNameError for a name that
    stands for nothing, ConfigError for a number that does not fit.
    """
    if isinstance(scenario, str | Path):
        is_file = str(scenario).endswith(".toml")
        scenario = from_toml(Path(scenario)) if is_file else SCENARIOS[str(scenario)]
    if not isinstance(scenario, Scenario | WaypointsScenario):
        raise ConfigError(f"scenario={scenario!r}: must be a name, a TOML file or a Scenario")
    return override(scenario, overrides or {}, "scenario parameter")


def find_foraging(
    scenario: str | Path | AnyScenario, overrides: Mapping[str, Any] | None = None
) -> Scenario:
    """The same for a scenario of foraging; ConfigError for one of waypoints."""
    found = find_scenario(scenario, overrides)
    if isinstance(found, WaypointsScenario):
        raise ConfigError(f"scenario '{found.name}': must be one in which robots forage, as es1")
    return found


def from_toml(file: Path) -> AnyScenario:
    """A scenario of the user's own: a TOML file with a table for each part, such as robot.

    `base = "es1"` at the top starts from a named scenario; without it, from the defaults.
    """
    try:
        tree = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"scenario file {file}: {error}") from None
    base = tree.pop("base", None)
    if not isinstance(base, str | None):
        raise ConfigError(f"scenario file {file}: base={base!r}: must be a name of a scenario")
    start: AnyScenario = Scenario() if base is None else SCENARIOS[base]
    return override(start, {"name": file.stem, **leaves(tree)}, "scenario parameter")
