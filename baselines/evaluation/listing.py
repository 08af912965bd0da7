"""The command `list`: scenarios, controllers and engines, with every field, unit and origin."""

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.controller import REGISTRIES, LayeredController
from baselines.evaluation.experiment_config import find_layered_controller
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.parameters import Part, leaves
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import (
    CONTROLLERS,
    ORIGINS,
    POLICIES,
    REFERENCES,
    SCENARIOS,
    Registry,
    left_out,
)
from swarm_forage_env.scenarios import find_scenario

UNIT = re.compile(r"\s*\[([^\]]+)\]")
ORIGIN = re.compile(r"\s*\(?\b(published|derived|chosen|code|set)\b\)?")


@dataclass(frozen=True)
class Parameter:
    """A field of a scenario or controller, as listed."""

    name: str
    value: Any
    unit: str
    origin: str
    """published, derived, chosen or code; set, if somebody changed the default; empty where the
    description does not say."""
    meaning: str


def overview() -> dict[str, list[dict[str, Any]]]:
    """All scenarios, controllers, references and engines, as nested dictionaries."""
    return {
        "scenarios": [describe(name) for name in SCENARIOS],
        "controllers": [describe(name) for name in CONTROLLERS],
        "references": [describe(name) for name in REFERENCES],
        "policies": [describe(name) for name in POLICIES],
        "engines": [{"name": name, "about": _first_line(ENGINES[name])} for name in ENGINES],
    }


def describe(name: str) -> dict[str, Any]:
    """Describe a scenario (name or TOML file) or a controller, as nested dictionaries."""
    found = find(name)
    groups = {group: [asdict(each) for each in listed] for group, _, listed in _groups(found)}
    if not isinstance(found, LayeredController):
        return {"name": found.name, "kind": "scenario", "parameters": groups}
    layers = found.layer_names
    return {"name": name, "kind": "controller", "layers": layers, "parameters": groups}


def find(name: str) -> Any:  # noqa: ANN401 a scenario of any task, or a controller
    """Find a scenario (name or TOML file) or a controller (`ssgiff:beta=0.02`)."""
    if name.endswith(".toml") or name in SCENARIOS:
        return find_scenario(name)
    bare = name.partition(":")[0]
    if not any(bare in each for each in (CONTROLLERS, POLICIES, REFERENCES)):
        known = [*SCENARIOS, *CONTROLLERS, *POLICIES, *REFERENCES]
        raise UnknownNameError("scenario or controller", bare, known, left_out())
    return find_layered_controller(name)


def units(found: Any) -> dict[str, str]:  # noqa: ANN401 as `find` gives
    """The unit of each field of a scenario or controller by dotted name; empty without one."""
    return {each.name: each.unit for _, _, listed in _groups(found) for each in listed}


def overview_tables() -> Group:
    """Tables of all names for a terminal."""
    return Group(
        _scenarios(), Text(), _controllers("controller", CONTROLLERS), Text(),
        Text("References, which know the truth: to compare with, not to use"),
        _controllers("reference", REFERENCES), Text(), _engines(), Text(), _policies(), Text(),
        Text("Every number of one of them: swarm-forage list es1, swarm-forage list ssgiff"),
    )  # fmt: skip


def detail_table(name: str) -> Group:
    """Tables of every parameter of one scenario or controller for a terminal."""
    found = find(name)
    parts: list[Any] = []
    for group, about, parameters in _groups(found):
        heading = Text(group, style="bold").append(f"  {about}", style="not bold")
        table = _table("parameter", "value", "unit", "origin", "meaning")
        for each in parameters:
            cells = each.name, _shown(each.value), each.unit, each.origin, each.meaning
            table.add_row(*map(Text, cells))
        parts += [heading, table, Text()]
    return Group(*parts, Text(f"Change one in evaluate with {_way(name, found)}"))


def _way(name: str, found: Any) -> str:  # noqa: ANN401 as `find` gives
    """How a number of what was found is changed on the command line."""
    bare = name.partition(":")[0]
    if not isinstance(found, LayeredController):
        return f"--set {_example(found)}"
    return f"{bare}:FILE,name=value" if bare in POLICIES else f"{bare}:name=value"


def _groups(found: Any) -> Iterator[tuple[str, str, list[Parameter]]]:  # noqa: ANN401 as `find` gives
    """Name, purpose and parameters of each part of a scenario or controller."""
    if not isinstance(found, LayeredController):
        origins = _origins(found)
        yield found.name, _first_line(found), list(_parameters(found, "", origins))
        for name, part in _parts(found):
            yield name, _first_line(part), list(_parameters(part, f"{name}.", origins))
        return
    for layer, part in found.layers.items():
        about = f"{found.layer_names[layer]}: {_first_line(part)}"
        yield layer, about, list(_parameters(part, f"{layer}.", None))


def _parts(whole: Part, prefix: str = "") -> Iterator[tuple[str, Part]]:
    """The parts of a scenario that have fields of their own, by dotted name."""
    for name, value in whole:
        if isinstance(value, Part):
            if any(not isinstance(each, Part) for _, each in value):
                yield prefix + name, value
            yield from _parts(value, f"{prefix}{name}.")


def _origins(scenario: Any) -> Mapping[str, str] | None:  # noqa: ANN401 of any task
    """Origins of a published scenario's own values; None for a scenario somebody made up."""
    is_of_paper = scenario.name in SCENARIOS and SCENARIOS[scenario.name] == scenario
    return ORIGINS.get(scenario.name, {}) if is_of_paper else None


def _parameters(part: Part, prefix: str, origins: Mapping[str, str] | None) -> Iterator[Parameter]:
    """The fields of a part, each with the origin of its value."""
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        if isinstance(value, Part):
            continue
        text = field.description or ""
        if origins is None and value != field.default and name != "name":
            text = f"{ORIGIN.sub('', text)} (set)"
        elif origins and prefix + name in origins:
            text = f"{text.partition('. ')[0]}. {origins[prefix + name]}"
        if isinstance(value, tuple):
            value = [each.model_dump() if isinstance(each, Part) else each for each in value]
        unit, origin = UNIT.search(text), ORIGIN.findall(text)
        meaning = re.sub(rf"\s*\({origin[-1]}\)$", "", text) if origin else text
        yield Parameter(
            prefix + name,
            value,
            unit[1] if unit else "",
            origin[-1] if origin else "",
            UNIT.sub("", meaning, count=1),
        )


def _scenarios() -> Table:
    table = _table("scenario", "robots", "arena [m]", "areas apart [m]", "duration [s]")
    for name in SCENARIOS:
        numbers = leaves(SCENARIOS[name].model_dump())
        side = numbers.get("task.side")
        sides = numbers.get("arena.length", side), numbers.get("arena.width", side)
        apart = None if numbers.get("task.areas") else numbers.get("task.area_distance")
        table.add_row(
            name,
            str(numbers["task.n_robots"]),
            " x ".join(f"{each:g}" for each in sides if each is not None),
            "" if apart is None else f"{apart:g}",
            f"{numbers['task.duration']:g}",
        )
    return table


def _controllers(kind: str, registry: Registry[Any]) -> Table:
    table = _table(kind, *REGISTRIES, "changed")
    for name in registry:
        controller: LayeredController = registry[name]
        table.add_row(name, *controller.layer_names.values(), ", ".join(_set(controller)))
    return table


def _policies() -> Table:
    table = _table("policy", "")
    for name in POLICIES:
        table.add_row(f"{name}:FILE", _first_line(POLICIES[name].policy))
    return table


def _set(controller: LayeredController) -> Iterator[str]:
    """The parameters of a controller that differ from their defaults, as a user writes them."""
    names = [name for part in controller.layers.values() for name in type(part).model_fields]
    for layer, part in controller.layers.items():
        for name, field in type(part).model_fields.items():
            if getattr(part, name) != field.default:
                full = name if names.count(name) == 1 else f"{layer}.{name}"
                yield f"{full}={_shown(getattr(part, name))}"


def _engines() -> Table:
    table = _table("engine", "")
    for name in ENGINES:
        table.add_row(name, _first_line(ENGINES[name]))
    return table


def _table(*headings: str) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in headings:
        table.add_column(Text(heading), overflow="fold")
    return table


EXAMPLES = ("radio.max_range", "task.tolerance")
"""Numbers that an example of a change is made with, where a scenario has them."""


def _example(scenario: Any) -> str:  # noqa: ANN401 of any task
    """How a number of the scenario is changed."""
    numbers = leaves(scenario.model_dump(exclude={"name"}))
    name = next(each for each in (*EXAMPLES, *numbers) if each in numbers)
    return f"{name}={_shown(numbers[name])}"


def _first_line(thing: object) -> str:
    """The first sentence of a docstring."""
    return (inspect.getdoc(thing) or "").partition("\n")[0]


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
