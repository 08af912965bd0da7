"""The command `list`: scenarios, controllers and engines, with every field, unit and origin."""

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.controller import LayeredController
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.evaluation.scores import EPISODES, Score, score_of_controller, score_of_scenario
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

PartT = TypeVar("PartT")
Listed = Any | LayeredController

UNIT = re.compile(r"\s*\[([^\]]+)\]")
ORIGIN = re.compile(r"\s*\(?\b(published|derived|chosen|code|set)\b\)?")


@dataclass(frozen=True)
class Parameter:
    """A field of a scenario or controller, as listed."""

    name: str
    value: object
    unit: str
    origin: str
    """published, derived, chosen or code; set, if somebody changed the default; empty where the
    description does not say."""
    meaning: str


def overview() -> dict[str, list[dict[str, object]]]:
    """All scenarios, controllers, references and engines, as nested dictionaries."""
    return {
        "scenarios": [describe(name) for name in SCENARIOS],
        "controllers": [describe(name) for name in CONTROLLERS],
        "references": [describe(name) for name in REFERENCES],
        "policies": [describe(name) for name in POLICIES],
        "engines": [{"name": name, "about": ENGINES.about(name)} for name in ENGINES],
    }


def describe(name: str) -> dict[str, object]:
    """Describe a scenario (name or TOML file) or a controller, as nested dictionaries."""
    found = find(name)
    groups = {
        group: [asdict(each) for each in listed] for group, _, listed in grouped_parameters(found)
    }
    told: dict[str, object] = {"about": _about(name), "parameters": groups}
    if not isinstance(found, LayeredController):
        score = score_of_scenario(name)
        return {"name": found.name, "kind": "scenario", "score": score and asdict(score), **told}
    score, layers = score_of_controller(name), found.layer_names
    score_told = score and asdict(score)
    return {"name": name, "kind": "controller", "layers": layers, "score": score_told, **told}


def find(name: str) -> Listed:
    """Find a scenario (name or TOML file) or a controller (`ssgiff:beta=0.02`)."""
    if name.endswith(".toml") or name in SCENARIOS:
        return find_scenario(name)
    bare = name.partition(":")[0]
    if not any(bare in each for each in (CONTROLLERS, POLICIES, REFERENCES)):
        known = [*SCENARIOS, *CONTROLLERS, *POLICIES, *REFERENCES]
        raise UnknownNameError("scenario or controller", bare, known, left_out())
    return find_layered_controller(name)


def _about(name: str) -> str:
    """What has this name, in words; empty for a file and for other numbers than the usual."""
    registries = SCENARIOS, CONTROLLERS, REFERENCES, POLICIES
    return next((each.about(name) for each in registries if name in set(each)), "")


def units(found: Listed) -> dict[str, str]:
    """The unit of each field of a scenario or controller by dotted name; empty without one."""
    return {each.name: each.unit for _, _, listed in grouped_parameters(found) for each in listed}


def grouped_parameters(found: Listed) -> Iterator[tuple[str, str, list[Parameter]]]:
    """Name, purpose and parameters of each part of a scenario or controller."""
    if not isinstance(found, LayeredController):
        is_of_paper = found.name in SCENARIOS and SCENARIOS[found.name] == found
        origins = ORIGINS.get(found.name, {}) if is_of_paper else None  # of a paper's own values
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


def _first_line(thing: object) -> str:
    return (inspect.getdoc(thing) or "").partition("\n")[0]


EXAMPLES = ("radio.max_range", "task.tolerance")
"""Numbers that an example of a change is made with, where a scenario has them."""

SCENARIO_SCORES = (
    "score: round trips under ssgikf, share gathered under gather, goals of a robot\n"
    f"under boids-adaptive; mean of {EPISODES} episodes"
)

CONTROLLER_SCORES = f"score: round trips on es1, mean of {EPISODES} episodes"


def overview_tables() -> Group:
    """Tables of all names."""
    return Group(
        _scenarios(), Text(SCENARIO_SCORES), Text(),
        _controllers("controller", CONTROLLERS), Text(CONTROLLER_SCORES), Text(),
        Text("References, which know the truth: to compare with, not to use"),
        _controllers("reference", REFERENCES), Text(),
        _named("engine", ENGINES), Text(), _named("policy", POLICIES, ":FILE"), Text(),
        Text("Every number of one of them: swarm-forage list es1, swarm-forage list ssgiff"),
    )  # fmt: skip


def detail_table(name: str) -> Group:
    """Tables of every parameter of one scenario or controller."""
    found = find(name)
    parts: list[Table | Text] = []
    for group, about, parameters in grouped_parameters(found):
        heading = Text(group, style="bold").append(f"  {about}", style="not bold")
        table = _table("parameter", "value", "unit", "origin", "meaning")
        for each in parameters:
            cells = each.name, _shown(each.value), each.unit, each.origin, each.meaning
            table.add_row(*map(Text, cells))
        parts += [heading, table, Text()]
    return Group(*parts, Text(f"Change one in evaluate with {_way(name, found)}"))


def _scenarios() -> Table:
    table = _table("scenario", "robots", "time [s]", "score", "what it is")
    for column in table.columns[1:4]:
        column.justify = "right"
    for name in SCENARIOS:
        task = SCENARIOS[name].task
        score, about = _score(score_of_scenario(name)), SCENARIOS.about(name)
        table.add_row(name, str(task.n_robots), f"{task.duration:g}", score, about)
    return table


def _controllers(kind: str, registry: Registry[PartT]) -> Table:
    table = _table(kind, "score", "what it is")
    table.columns[1].justify = "right"
    for name in registry:
        table.add_row(name, _score(score_of_controller(name)), registry.about(name))
    return table


def _named(kind: str, registry: Registry[PartT], after: str = "") -> Table:
    table = _table(kind, "what it is")
    for name in registry:
        table.add_row(f"{name}{after}", registry.about(name))
    return table


def _table(*headings: str) -> Table:
    """A table of words, the first of which is a name."""
    table = Table(box=None, padding=(0, 2, 0, 0))
    for number, heading in enumerate(headings):
        table.add_column(Text(heading), overflow="fold", no_wrap=number == 0)
    return table


def _score(score: Score | None) -> str:
    return "" if score is None else f"{score.mean:.{0 if score.mean >= 10.0 else 1}f}"


def _way(name: str, found: Listed) -> str:
    """How a number is changed in `evaluate`."""
    if isinstance(found, LayeredController):
        bare = name.partition(":")[0]
        return f"{bare}:FILE,name=value" if bare in POLICIES else f"{bare}:name=value"
    numbers = leaves(found.model_dump(exclude={"name"}))
    example = next(each for each in (*EXAMPLES, *numbers) if each in numbers)
    return f"--set {example}={_shown(numbers[example])}"


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
