"""Tables of a card: what a policy sees and gives, and every number of a scenario."""

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from baselines.evaluation.listing import describe
from swarm_forage_env import find_scenario, parallel_env
from swarm_forage_env.spaces import Layout
from swarm_forage_env.task import task_of

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parent / "templates"),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)

HEADS = "numbers", "name", "unit and scale", "from", "to", "noise", "meaning"


def rendered(template: str, **terms: object) -> str:
    """The text of a card, from its template."""
    return TEMPLATES.get_template(f"{template}.md.j2").render(**terms)


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown; columns in which nothing stands are left out."""
    shown = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    lines = [[line[k] for k in shown] for line in (heads, ["---"] * len(heads), *rows)]
    escaped = ([cell.replace("|", r"\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in escaped)


def policy(name: str, learn: str) -> str:
    """Observation and action of a policy as tables."""
    env = parallel_env(name, learn=learn)
    observes = task_of(find_scenario(name)).policies[learn].observes
    meanings = {
        f"{each.part}.{each.shown_as}": _field_docstrings(each.record).get(each.name, "")
        for each in observes
    }
    seen, given = env.observation_layout, env.action_layout
    return (
        f'### Observation of `learn="{learn}"`, {_counted(seen)} {{ #sees-{learn} }}\n\n'
        f"{table(HEADS, list(_rows(seen, meanings)))}\n\n"
        f'### Action of `learn="{learn}"`, {_counted(given)} {{ #gives-{learn} }}\n\n'
        f"{table(HEADS[:5], [row[:5] for row in _rows(given, {})])}\n"
    )


def _counted(layout: Layout) -> str:
    return f"{len(layout)} number{'s' if len(layout) > 1 else ''}"


def _rows(layout: Layout, meanings: Mapping[str, str]) -> Iterator[tuple[str, ...]]:
    """A row for the features of a field that have the same unit, bounds and noise."""
    groups: dict[tuple[object, ...], list[tuple[int, str]]] = {}
    for number, each in enumerate(layout):
        first, _, rest = each.name.partition(".")
        field = first if rest.isdigit() else ".".join(each.name.split(".")[:2])
        end = each.name.removeprefix(field).strip(".")
        key = field, each.unit, each.low, each.high, each.noise
        groups.setdefault(key, []).append((number, end))
    for (field, unit, low, high, noise), found in groups.items():
        numbers, ends = zip(*found, strict=True)
        shown = f"`{field}` {_ends(ends)}".strip()
        yield _runs(numbers), shown, unit, f"{low:g}", f"{high:g}", noise, meanings.get(field, "")


def _runs(numbers: Sequence[int]) -> str:
    """Numbers as they follow each other: "3", "0 to 7", "29, 32, 35"."""
    first, last = numbers[0], numbers[-1]
    if first == last:
        return str(first)
    is_run = last - first == len(numbers) - 1
    return f"{first} to {last}" if is_run else ", ".join(map(str, numbers))


def _ends(ends: Sequence[str]) -> str:
    return ", ".join(ends) if len(ends) <= 6 else f"{ends[0]} to {ends[-1]}"


def _field_docstrings(kind: type) -> dict[str, str]:
    """The docstring below each field of a record, as one line."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for field, below in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(below, ast.Expr):
            text = ast.literal_eval(below.value)
            found[ast.unparse(field.target)] = " ".join(text.split())
    return found


def numbers(name: str) -> str:
    """Every number of a scenario with unit, origin and meaning."""
    rows = [
        (f"`{each['name']}`", _value(each["value"]), each["unit"], each["origin"], each["meaning"])
        for group in describe(name)["parameters"].values()
        for each in group
    ]
    return table(("name", "value", "unit", "origin", "meaning"), rows) + "\n"


def _value(value: object) -> str:
    """A number of a scenario as it is written in a TOML file, with six digits."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
