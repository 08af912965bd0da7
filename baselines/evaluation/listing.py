"""Command `list`: scenarios, controllers, layers and engines, with every field and unit."""

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import TypeVar

from rich.console import Group, JustifyMethod
from rich.table import Table
from rich.text import Text

from baselines.controller import REGISTRIES, LayeredController
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.evaluation.scores import EPISODES, score_of
from swarm_forage_env.controllers import parse_controller
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.parameters import BaseScenario, Parameters, leaves, override
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

PartT = TypeVar("PartT")
Listed = BaseScenario | LayeredController | Parameters  # the last one is a layer

LISTED = SCENARIOS, CONTROLLERS, POLICIES, REFERENCES, *REGISTRIES.values()

UNIT = re.compile(r"\s*\[([^\]]+)\]")
ORIGIN = re.compile(r"\s*\(?\b(published|derived|chosen|code|set)\b\)?")


@dataclass(frozen=True)
class Parameter:
    """Field of a scenario, controller or layer, as listed."""

    name: str
    value: object
    unit: str
    origin: str
    """published, derived, chosen or code; set if it differs from the default; empty if unknown."""
    meaning: str


def overview() -> dict[str, list[dict[str, object]]]:
    """Return scenarios, controllers, references, policies, layers and engines, as dictionaries."""
    return {
        "scenarios": [describe(name) for name in SCENARIOS],
        "controllers": [describe(name) for name in CONTROLLERS],
        "references": [describe(name) for name in REFERENCES],
        "policies": [describe(name) for name in POLICIES],
        "layers": [{"kind": layer, "names": [*names]} for layer, names in REGISTRIES.items()],
        "engines": [{"name": name, "about": ENGINES.about(name)} for name in ENGINES],
    }


def describe(name: str) -> dict[str, object]:
    """Describe a scenario (name or TOML file), controller or layer, as nested dictionaries."""
    listed = find(name)
    groups = {group: [asdict(each) for each in own] for group, _, own in grouped_parameters(listed)}
    head: dict[str, object] = {"name": name, "kind": next(iter(groups))}
    if isinstance(listed, LayeredController):
        head |= {"kind": "controller", "layers": listed.layer_names}
    elif isinstance(listed, BaseScenario):
        head = {"name": listed.name, "kind": "scenario"}
    score = score_of(name)
    return head | {"score": score and asdict(score), "about": _about(name), "parameters": groups}


def find(name: str) -> Listed:
    """Find a scenario (name or TOML file), a controller (`ssgiff:beta=0.02`) or a layer."""
    bare = name.partition(":")[0]
    if name.endswith(".toml") or bare in SCENARIOS:
        scenario: BaseScenario = find_scenario(name)
        return scenario
    if any(bare in each for each in (CONTROLLERS, POLICIES, REFERENCES)):
        return find_layered_controller(name)
    for registry in REGISTRIES.values():
        if bare in registry:
            return override(registry[bare](), parse_controller(name)[1])
    known = [each for registry in LISTED for each in registry]
    raise UnknownNameError("scenario, controller or layer", bare, known, left_out())


def _about(name: str) -> str:
    """Return the description of a name; empty for a file and for a name with parameters."""
    return next((each.about(name) for each in LISTED if name in set(each)), "")


def units(listed: Listed) -> dict[str, str]:
    """Return the unit of each field by dotted name; empty without one."""
    groups = (parameters for _, _, parameters in grouped_parameters(listed))
    return {each.name: each.unit for parameters in groups for each in parameters}


def grouped_parameters(listed: Listed) -> Iterator[tuple[str, str, list[Parameter]]]:
    """Yield name, purpose and parameters of each part of a scenario, controller or layer."""
    if not isinstance(listed, BaseScenario):
        for layer, (name, part) in _layers(listed).items():
            yield layer, f"{name}: {_first_line(part)}", list(_parameters(part, f"{layer}.", None))
        return
    is_of_paper = listed.name in SCENARIOS and SCENARIOS[listed.name] == listed
    origins = ORIGINS.get(listed.name, {}) if is_of_paper else None  # of the values of a paper
    yield listed.name, _first_line(listed), list(_parameters(listed, "", origins))
    for name, part in _parts(listed):
        if parameters := list(_parameters(part, f"{name}.", origins)):
            yield name, _first_line(part), parameters


def _layers(listed: LayeredController | Parameters) -> dict[str, tuple[str, Parameters]]:
    """Return the layers of a controller, or the one layer, as (name, layer) by kind."""
    if isinstance(listed, LayeredController):
        return {layer: (listed.layer_names[layer], part) for layer, part in listed.layers.items()}
    names = {layer: each.name_of(type(listed)) for layer, each in REGISTRIES.items()}
    return {layer: (name, listed) for layer, name in names.items() if name}


def _parts(group: Parameters, prefix: str = "") -> Iterator[tuple[str, Parameters]]:
    for name, value in group:
        if isinstance(value, Parameters):
            yield prefix + name, value
            yield from _parts(value, f"{prefix}{name}.")


def _parameters(
    part: Parameters, prefix: str, origins: Mapping[str, str] | None
) -> Iterator[Parameter]:
    for name, value in part:
        if isinstance(value, Parameters):
            continue
        field = type(part).model_fields[name]
        text = field.description or ""
        if origins is None and value != field.default and name != "name":
            text = f"{ORIGIN.sub('', text)} (set)"
        elif origins and prefix + name in origins:
            text = f"{text.partition('. ')[0]}. {origins[prefix + name]}"
        if isinstance(value, tuple):
            value = [each.model_dump() if isinstance(each, Parameters) else each for each in value]
        unit, origin = UNIT.search(text), (ORIGIN.findall(text) or [""])[-1]
        meaning = UNIT.sub("", text, count=1).removesuffix(f" ({origin})")
        yield Parameter(prefix + name, value, unit[1] if unit else "", origin, meaning)


def _first_line(thing: object) -> str:
    return (inspect.getdoc(thing) or "").partition("\n")[0]


EXAMPLES = ("radio.max_range", "task.tolerance")
"""Parameters that an example of a change uses, if the scenario has them."""

SCENARIO_SCORES = (
    "score: round trips with ssgikf, share gathered with gather, goals per robot"
    f" with\nboids-adaptive; mean of {EPISODES} episodes"
)

CONTROLLER_SCORES = f"score: round trips on es1, mean of {EPISODES} episodes"


def overview_tables() -> Group:
    """Return tables of all names, with scores and descriptions."""
    scenarios = _table("scenario", "robots", "time [s]", "score", "what it is")
    for name in SCENARIOS:
        task, about = SCENARIOS[name].task, SCENARIOS.about(name)
        scenarios.add_row(name, str(task.n_robots), f"{task.duration:g}", _score(name), about)
    names = "names; three of them make a controller: social_odometry+sgikf+subsumption"
    layers = _table("layer", names)
    for layer, registry in REGISTRIES.items():
        layers.add_row(layer, ", ".join(registry))
    return Group(
        scenarios, Text(SCENARIO_SCORES), Text(),
        _controllers("controller", CONTROLLERS), Text(CONTROLLER_SCORES), Text(),
        Text("References know the ground truth: for comparison only"),
        _controllers("reference", REFERENCES), Text(),
        _named("engine", ENGINES), Text(), _named("policy", POLICIES, ":FILE"), Text(),
        layers, Text(),
        Text("All parameters of one entry: swarm-forage list es1, swarm-forage list ssgiff"),
    )  # fmt: skip


def detail_table(name: str) -> Group:
    """Return tables of every parameter of one scenario, controller or layer."""
    listed = find(name)
    parts: list[Table | Text] = []
    for group, about, parameters in grouped_parameters(listed):
        heading = Text(group, style="bold").append(f"  {about}", style="not bold")
        table = _table("parameter", "value", "unit", "origin", "meaning")
        for each in parameters:
            cells = each.name, _shown(each.value), each.unit, each.origin, each.meaning
            table.add_row(*map(Text, cells))
        parts += [heading, table, Text()]
    return Group(*parts, Text(f"To set one in evaluate: {_way(name, listed)}"))


def _controllers(kind: str, registry: Registry[PartT]) -> Table:
    table = _table(kind, "score", "what it is")
    for name in registry:
        table.add_row(name, _score(name), registry.about(name))
    return table


def _named(kind: str, registry: Registry[PartT], after: str = "") -> Table:
    table = _table(kind, "what it is")
    for name in registry:
        table.add_row(f"{name}{after}", registry.about(name))
    return table


def _table(name: str, *headings: str) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column(Text(name), no_wrap=True)
    for heading in headings:
        justify: JustifyMethod = "right" if heading in ("robots", "time [s]", "score") else "left"
        table.add_column(Text(heading), overflow="fold", justify=justify)
    return table


def _score(name: str) -> str:
    score = score_of(name)
    return "" if score is None else f"{score.mean:.{0 if score.mean >= 10.0 else 1}f}"


def _way(name: str, listed: Listed) -> str:
    if isinstance(listed, LayeredController):
        bare = name.partition(":")[0]
        return f"{bare}:FILE,name=value" if bare in POLICIES else f"{bare}:name=value"
    if not isinstance(listed, BaseScenario):
        bare, (own,) = name.partition(":")[0], _layers(listed)
        layers = (bare if each == own else each.upper() for each in REGISTRIES)
        return f"{'+'.join(layers)}:name=value"
    numbers = leaves(listed.model_dump(exclude={"name"}))
    example = next(each for each in (*EXAMPLES, *numbers) if each in numbers)
    return f"--set {example}={_shown(numbers[example])}"


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
