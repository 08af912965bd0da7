"""The command `list`: scenarios, controllers and engines, with every field, unit and origin."""

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from baselines.controller import LayeredController
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.evaluation.scores import score_of_controller, score_of_scenario
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.parameters import Part
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import (
    CONTROLLERS,
    ORIGINS,
    POLICIES,
    REFERENCES,
    SCENARIOS,
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
        "engines": [{"name": name, "about": ENGINES.about(name)} for name in ENGINES],
    }


def describe(name: str) -> dict[str, Any]:
    """Describe a scenario (name or TOML file) or a controller, as nested dictionaries."""
    found = find(name)
    groups = {
        group: [asdict(each) for each in listed] for group, _, listed in grouped_parameters(found)
    }
    told = {"about": _about(name), "parameters": groups}
    if not isinstance(found, LayeredController):
        score = score_of_scenario(name)
        return {"name": found.name, "kind": "scenario", "score": score and asdict(score)} | told
    score, layers = score_of_controller(name), found.layer_names
    kind = {"kind": "controller", "layers": layers, "score": score and asdict(score)}
    return {"name": name} | kind | told


def find(name: str) -> Any:  # noqa: ANN401 a scenario of any task, or a controller
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


def units(found: Any) -> dict[str, str]:  # noqa: ANN401 as `find` gives
    """The unit of each field of a scenario or controller by dotted name; empty without one."""
    return {each.name: each.unit for _, _, listed in grouped_parameters(found) for each in listed}


def grouped_parameters(found: Any) -> Iterator[tuple[str, str, list[Parameter]]]:  # noqa: ANN401 as `find` gives
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


def _first_line(thing: object) -> str:
    """The first sentence of a docstring."""
    return (inspect.getdoc(thing) or "").partition("\n")[0]
