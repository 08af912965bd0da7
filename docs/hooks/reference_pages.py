"""The reference: an index and, for each class, function or module that it names, a page.

A line `::: NAME` of an index names one, under the path that a user imports it by.
"""

import re
from functools import cache

import griffe
import parameter_tables
from card_tables import table
from source_pages import ROOT

ENTRIES = re.compile(r"(?:^::: \S+\n?)+", re.MULTILINE)
INDEXES = "world", "baselines", "training"

LINE = 90
"""Letters of a call that stays on one line."""


def names(index: str) -> list[str]:
    """What an index names, in order."""
    return re.findall(r"^::: (\S+)", index, re.MULTILINE)


def with_tables(index: str) -> str:
    """The text of an index, its entries as tables that link to their pages."""
    return ENTRIES.sub(lambda found: _table(names(found[0])), index)


def page(name: str, index: str) -> str:
    """The page of a name: how it is imported and called, and what mkdocstrings says of it."""
    module, _, last = name.rpartition(".")
    found = _found(name)
    if found.is_module:
        title, code = name, f"import {name}"
    else:
        title, code = last, f"from {module} import {last}{_call(found)}"
    heading = (ROOT / "docs" / "reference" / f"{index}.md").read_text("utf-8").partition("\n")[0]
    options = "    options:\n      show_root_heading: false\n      heading_level: 2\n"
    return (
        f"# {title}\n\n[{heading.removeprefix('# ')}]({index}.md)\n\n"
        f"```python\n{code}\n```\n\n::: {name}\n{options}"
    )


def _call(found: griffe.Object | griffe.Alias) -> str:
    """How something is called: with types where no table says them; nothing for a record."""
    maker = found.members.get("__init__") if found.is_class else found
    if not isinstance(getattr(maker, "parameters", None), griffe.Parameters):
        return ""
    documented = [found.docstring, maker.docstring]
    has_table = any("Args:" in each.value for each in documented if each is not None)
    given = [_argument(each, has_table) for each in maker.parameters if each.name != "self"]
    line = f"{found.name}({', '.join(given)})"
    if len(line) > LINE:
        line = f"{found.name}(\n" + "".join(f"    {each},\n" for each in given) + ")"
    result = (
        "" if has_table or found.is_class or maker.returns is None else f"  # -> {maker.returns}"
    )
    return f"\n\n{line}{result}"


def _argument(parameter: griffe.Parameter, has_table: bool) -> str:
    stars = {"variadic positional": "*", "variadic keyword": "**"}
    kind = parameter.kind.value if parameter.kind is not None else ""
    if kind in stars:
        return stars[kind] + parameter.name
    text = parameter.name if has_table else f"{parameter.name}: {parameter.annotation}"
    return text if parameter.default is None else f"{text}={parameter.default}"


@cache
def keywords() -> str:
    """The keywords of every environment, as a table."""
    made = _found("swarm_forage_env.parallel_env")
    return parameter_tables.keywords(made.docstring.value, made.members["__init__"].parameters)


def _table(chosen: list[str]) -> str:
    rows = [(f"[`{_short(name)}`]({name}.md)", _summary(name)) for name in chosen]
    return table(("name", "what it is"), rows) + "\n"


def _short(name: str) -> str:
    return name if _found(name).is_module else name.rpartition(".")[2]


def _summary(name: str) -> str:
    """The first paragraph of the docstring of a name, as one line."""
    docstring = _found(name).docstring
    assert docstring is not None, name
    return " ".join(docstring.value.partition("\n\n")[0].split()).removesuffix(":")


@cache
def _package(name: str) -> griffe.Object | griffe.Alias:
    return griffe.load(name, search_paths=[ROOT], resolve_aliases=True)


def _found(name: str) -> griffe.Object | griffe.Alias:
    package, _, rest = name.partition(".")
    return _package(package)[rest]
