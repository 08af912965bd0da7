"""Edits of the source code that make a set of values the defaults; they are printed, not made."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from inspect import getsourcefile
from pathlib import Path
from typing import Any

import baselines
from baselines.controllers import SINGLE, SUBSUMPTION
from calibration.ranges import Values, defaults
from swarm_forage_env.foraging import named
from swarm_forage_env.foraging.scenario import Radio, Robot, Sensors, Task
from swarm_forage_env.registry import SCENARIOS

MODELS: dict[str, Any] = {
    "robot": Robot,
    "sensors": Sensors,
    "radio": Radio,
    "estimator": type(SINGLE),
    "motion": type(SUBSUMPTION),
    "es1": Task,
}
"""Where the default of a parameter stands, by the first word of its name."""

ROOT = Path(baselines.__file__).parents[1]
"""Files are named relative to this folder."""


@dataclass(frozen=True)
class SourceEdit:
    """A line of code and what a set of values changes it to."""

    file: str
    number: int
    before: str
    after: str

    def __str__(self) -> str:
        """The edit as in a patch."""
        return f"{self.file}:{self.number}\n- {self.before}\n+ {self.after}"


def source_edits(values: Values) -> Iterator[SourceEdit]:
    """The edits for the values that are not the defaults already."""
    before = defaults()
    for name, value in values.items():
        if value == before[name]:
            continue
        part, _, leaf = name.partition(".")
        if part in MODELS:
            yield _default(MODELS[part], leaf, value)
        else:
            yield _argument(part, leaf, value)
        if name == "radio.exchange_time":
            longer = SCENARIOS["real"].radio.exchange_time / before[name]
            yield _argument("real", leaf, round(longer * value, 4))


def _default(model: Any, field: str, value: float) -> SourceEdit:  # noqa: ANN401 any class of a Part
    """The line with the default of a model's field."""
    file = Path(getsourcefile(model) or "")
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef) and node.name == model.__name__:
            for entry in node.body:
                if isinstance(entry, ast.AnnAssign) and ast.unparse(entry.target) == field:
                    assert isinstance(entry.value, ast.Call)
                    return _change(file, entry.value.args[0], value)
    raise LookupError(f"{file}: no default of {model.__name__}.{field}")


def _argument(scenario: str, name: str, value: float) -> SourceEdit:
    """The line with an argument of a scenario, in the module that makes the scenarios."""
    file = Path(named.__file__)
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == scenario.upper():
            for inner in ast.walk(node.value):
                if isinstance(inner, ast.keyword) and inner.arg == name:
                    return _change(file, inner.value, value)
    raise LookupError(f"{file}: {scenario} has no argument {name}")


def _change(file: Path, node: ast.expr, value: float) -> SourceEdit:
    """The line of an expression, and the same with a number in its place."""
    before = file.read_text(encoding="utf-8").splitlines()[node.lineno - 1]
    after = f"{before[: node.col_offset]}{value!r}{before[node.end_col_offset :]}"
    return SourceEdit(file.relative_to(ROOT).as_posix(), node.lineno, before, after)
