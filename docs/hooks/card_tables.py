"""Tables of a card: what a policy sees and gives, and every number of a scenario."""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from baselines.evaluation.listing import describe
from swarm_forage_env import parallel_env


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    escaped = ([cell.replace("|", r"\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in escaped)


def policy(name: str, learn: str) -> str:
    """Observation and action of a policy as tables."""
    env = parallel_env(name, learn=learn)
    meanings = {
        f"{part}.{key}": text
        for part, kind in getattr(env.observation_layout, "inputs", {}).items()
        for key, text in _field_docstrings(kind).items()
    }
    seen, given = env.observation_layout, env.action_layout
    heads = "numbers", "name", "unit and scale", "from", "to", "noise"
    return (
        f'### Observation of `learn="{learn}"`, {len(seen)} numbers {{ #sees-{learn} }}\n\n'
        f"{table((*heads, 'meaning'), list(_rows(seen, meanings)))}\n\n"
        f'### Action of `learn="{learn}"`, {len(given)} numbers {{ #gives-{learn} }}\n\n'
        f"{table(heads[:5], [row[:5] for row in _rows(given, {})])}\n"
    )


def _rows(layout: Sequence[Any], meanings: Mapping[str, str]) -> Iterator[tuple[str, ...]]:
    """A row for each run of features that differ in the counted part of their name only."""
    indexed = list(enumerate(layout))

    def group(pair: tuple[int, Any]) -> tuple[Any, ...]:
        feature = pair[1]
        field = _field(feature.name)
        return field, feature.unit, feature.low, feature.high, feature.noise

    for (field, unit, low, high, noise), found in groupby(indexed, group):
        each = list(found)
        first, last = each[0][0], each[-1][0]
        number = str(first) if first == last else f"{first} to {last}"
        ends = [pair[1].name.removeprefix(field).strip(".") for pair in each]
        shown = f"`{field}`" + (f" {_ends(ends)}" if ends != [""] else "")
        yield number, shown, unit, f"{low:g}", f"{high:g}", noise, meanings.get(field, "")


def _field(name: str) -> str:
    """The part and the field of a dotted name."""
    return ".".join(name.split(".")[:2])


def _ends(ends: Sequence[str]) -> str:
    return ", ".join(ends) if len(ends) <= 6 else f"{ends[0]} to {ends[-1]}"


def _field_docstrings(kind: type[Any]) -> dict[str, str]:
    """The docstring below each field of a dataclass, as one line."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for field, below in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(below, ast.Expr):
            text = ast.literal_eval(below.value)
            found[ast.unparse(field.target)] = re.sub(r"\s+", " ", text).strip()
    return found


def numbers(name: str) -> str:
    """Every number of a scenario with unit, origin and meaning."""
    rows = [
        (f"`{each['name']}`", str(each["value"]), each["unit"], each["origin"], each["meaning"])
        for group in describe(name)["parameters"].values()
        for each in group
    ]
    return table(("name", "value", "unit", "origin", "meaning"), rows) + "\n"
