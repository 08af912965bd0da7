"""Extensions of mkdocstrings: fields of classes and arguments of functions become tables.

The fields of a model or a record become one table with type, default, unit and meaning, and so do
the arguments that a section `Args:` of a docstring describes. An argument `**options` stands for
the fields of `EnvConfig`. Examples of docstrings become blocks of code, and lists lists.
"""

import ast
import re
from collections.abc import Iterator
from functools import cache

import card_tables
import griffe
from source_pages import ROOT

UNIT = re.compile(r"\s*\[(?![-\d])([^\]]+)\]")
"""A unit in brackets; an interval of numbers is none."""

ARGUMENTS = re.compile(r"^Args:\n(?:(?: {4}.*)?\n?)+", re.MULTILINE)
OPTIONS = "**options"
KEYWORDS = "swarm_forage_env.envs.config.EnvConfig"
TYPED = "swarm_forage_env.envs.keywords"
"""Where the same keywords have the types that editors know."""

TYPES = {
    "Share": "float, 0 to 1",
    "Probability": "float, 0 to 1",
    "Positive": "float > 0",
    "NotNegative": "float >= 0",
    "Count": "int >= 1",
    "Observed": "str or class",
}
"""Types of the project, as a reader knows them."""

HEADS = "name", "type", "default", "unit", "meaning"

Row = tuple[str, str, str, str]
"""Name, type, default, and meaning with its unit."""


class ParameterTables(griffe.Extension):
    """Writes the tables into docstrings, and takes the fields out of the members."""

    def on_class(self, *, cls: griffe.Class | griffe.Alias, **_: object) -> None:
        """A table of the fields of a class, and one of the arguments that its docstring names."""
        if cls.is_alias or cls.docstring is None:
            return
        for docstring in (cls.docstring, getattr(cls.members.get("__init__"), "docstring", None)):
            if docstring is not None and "__init__" in cls.members:
                docstring.value = with_table(docstring.value, cls.members["__init__"].parameters)
        fields = {row[0]: row for row in fields_of(cls)}  # a field that it defines again is its own
        if len(fields) > 1:
            cls.docstring.value += f"\n\n{table(list(fields.values()))}\n"
            for name in [name for name, each in cls.members.items() if _is_field(each)]:
                del cls.members[name]

    def on_function(self, *, func: griffe.Function | griffe.Alias, **_: object) -> None:
        """A table in the place of the section of arguments."""
        if not func.is_alias and func.docstring is not None and func.name != "__init__":
            func.docstring.value = with_table(func.docstring.value, func.parameters)


class DoctestFences(griffe.Extension):
    """Fences every paragraph that starts with `>>>`, which Markdown takes for a quotation.

    A list that follows a sentence at once is set apart, as Markdown asks.
    """

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        """Fence the examples of one docstring."""
        if obj.docstring is not None:
            obj.docstring.value = "\n\n".join(map(_fenced, obj.docstring.value.split("\n\n")))


def with_table(docstring: str, parameters: griffe.Parameters) -> str:
    """A docstring whose section of arguments is a table."""
    return ARGUMENTS.sub(lambda found: table(list(_arguments(found[0], parameters))), docstring)


def keywords(text: str, parameters: griffe.Parameters) -> str:
    """The table of the arguments of a docstring alone."""
    found = ARGUMENTS.search(text)
    assert found is not None
    return table(list(_arguments(found[0], parameters)))


def table(rows: list[Row]) -> str:
    """A table in Markdown, in which units have a column."""
    full = []
    for *row, text in rows:
        meaning = " ".join(text.split())
        full.append((*row, _unit(meaning), UNIT.sub("", meaning, count=1)))
    return card_tables.table(HEADS, full) + "\n"


def fields_of(cls: griffe.Object | griffe.Alias) -> Iterator[Row]:
    """The fields of a class, those that it inherits first."""
    for base in cls.bases:
        found = base if isinstance(base, griffe.Expr) else None
        if found is not None and (path := found.canonical_path).startswith("swarm_forage_env."):
            yield from fields_of(loaded(path))
    for name, each in cls.members.items():
        if _is_field(each):
            default, meaning = _value(each)
            yield f"`{name}`", _type(each.annotation), default, meaning


@cache
def loaded(path: str) -> griffe.Object | griffe.Alias:
    """A class of the environments, read without extensions."""
    module, _, name = path.rpartition(".")
    return griffe.load(module, search_paths=[ROOT])[name]


def _is_field(member: griffe.Object | griffe.Alias) -> bool:
    """Whether a member is declared in the body of its class, and not made of others by a method."""
    is_plain = not member.is_alias and member.is_attribute and not member.name.startswith("_")
    is_plain = is_plain and not str(member.value).startswith("self.")
    return is_plain and member.annotation is not None and "instance-attribute" in member.labels


def _value(attribute: griffe.Object | griffe.Alias) -> tuple[str, str]:
    """The default of a field, and what its description or docstring says, with its unit."""
    text = attribute.docstring.value if attribute.docstring else ""
    if attribute.value is None:
        return "", text
    value = str(attribute.value)
    call = ast.parse(value, mode="eval").body
    if not (isinstance(call, ast.Call) and getattr(call.func, "id", "") in ("Field", "field")):
        return f"`{value}`", text
    given = {each.arg: each.value for each in call.keywords}
    if call.func.id == "field":  # of a record
        unit = f" [{ast.literal_eval(given['unit'])}]" if "unit" in given else ""
        return "", text if UNIT.search(text) else text + unit
    if "description" in given:
        text = _text(given["description"], attribute.module)
    if "default_factory" in given:
        return f"`{ast.unparse(given['default_factory'])}()`", text
    return (f"`{ast.unparse(call.args[0])}`" if call.args else ""), text


def _text(node: ast.expr, module: griffe.Module) -> str:
    """A text as it stands in a module; in braces it may name constants of that module."""
    if not isinstance(node, ast.JoinedStr):
        return str(ast.literal_eval(node))
    names = {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}
    constants = {name: ast.literal_eval(str(module[name].value)) for name in names}
    return str(eval(compile(ast.Expression(node), module.name, "eval"), constants))


def _arguments(section: str, parameters: griffe.Parameters) -> Iterator[Row]:
    _, parsed = griffe.Docstring(f"Of\n\n{section}").parse("google", warnings=False)
    for each in parsed.value:
        if each.name == OPTIONS:
            yield from _further(parameters)
            continue
        if (name := each.name.lstrip("*")) not in parameters:
            raise ValueError(f"Args: no argument {name!r} among {[p.name for p in parameters]}")
        default = None if "*" in each.name else parameters[name].default
        kind = _type(parameters[name].annotation)
        yield f"`{each.name}`", kind, f"`{default}`" if default else "", each.description


def _further(parameters: griffe.Parameters) -> Iterator[Row]:
    """The fields of `EnvConfig` that are not arguments themselves."""
    named = {f"`{parameter.name}`" for parameter in parameters}
    types = dict(_typed("EnvOptions"))
    for name, kind, default, meaning in fields_of(loaded(KEYWORDS)):
        if name not in named:
            is_vague = kind in ("`object`", "`str`", "`str or None`")
            yield name, types[name] if is_vague else kind, default, meaning


def _typed(options: str) -> Iterator[tuple[str, str]]:
    """The keywords of a TypedDict, those that it inherits first, and their types."""
    cls = loaded(f"{TYPED}.{options}")
    for base in map(str, cls.bases):
        yield from () if base == "TypedDict" else _typed(base)
    yield from ((f"`{name}`", _type(each.annotation)) for name, each in cls.members.items())


@cache
def _choices() -> dict[str, str]:
    """The names of types that stand for a few words, and these words."""
    members = griffe.load(TYPED, search_paths=[ROOT]).members.items()
    own = [(name, each) for name, each in members if not each.is_alias and each.is_attribute]
    values = {name: str(each.value) for name, each in own}
    words = {name: re.findall(r"'[\w-]+'|Callable", value) for name, value in values.items()}
    return {name: " or ".join(each) for name, each in words.items() if each and name not in TYPES}


def _type(annotation: object) -> str:
    text = str(annotation) if annotation is not None else ""
    text = re.sub(r"Annotated\[(\w+), [^\]]*\]", r"\1", text)
    text = re.sub(r"Literal\[([^\]]*)\]", lambda found: found[1].replace(", ", " or "), text)
    text = re.sub(r"\w+", lambda word: _choices().get(word[0], word[0]), text)
    words = re.sub(r"\w+", lambda word: TYPES.get(word[0], word[0]), text.replace(" | ", " or "))
    return f"`{words}`" if text else ""


def _unit(meaning: str) -> str:
    found = UNIT.search(meaning)
    return found[1] if found else ""


def _fenced(paragraph: str) -> str:
    is_example = paragraph.lstrip().startswith(">>>")
    if is_example:
        return f"```pycon\n{paragraph}\n```"
    return re.sub(r":\n- ", ":\n\n- ", paragraph)
