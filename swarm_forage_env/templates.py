"""Templates: functions with free names, which are bound to the functions of chosen parts.

A template of a block loops over worlds. It may call row templates, of one world or of one robot,
which are bound with it.
"""

from collections.abc import Callable, Iterator, Mapping
from types import FunctionType
from typing import TypeVar, cast

Function = Callable[..., object]
"""A function in Python, or a compiled one."""

FunctionT = TypeVar("FunctionT", bound=Function)

Bindings = tuple[tuple[str, Function], ...]
"""Pairs of a free name and the function that is bound to it, in the order of names."""

_row_templates: set[Function] = set()


def row_template(template: FunctionT) -> FunctionT:
    """Mark a template of one world or robot; it is bound with the template that names it."""
    _row_templates.add(template)
    return template


def is_row_template(function: object) -> bool:
    """Return whether a function is a template of one world or robot."""
    return isinstance(function, FunctionType) and function in _row_templates


def parts_of(template: Function, functions: Mapping[str, Function]) -> Bindings:
    """Return the functions that the template, or a template that it names, has free names for."""
    names = set(_free_names(template, functions))
    used = ((name, each) for name, each in functions.items() if name in names)
    return tuple(sorted(used, key=lambda part: part[0]))


def with_parts(
    template: Function, parts: Bindings, compiled: Callable[[Function, Bindings], Function]
) -> FunctionType:
    """Return a template as a function whose free names are bound to these parts.

    `compiled` compiles each row template that the template names or that is a part.
    """
    function, rows = cast(FunctionType, template), _rows_in(template, dict(parts))
    bound_rows = {name: compiled(each, parts) for name, each in rows.items()}
    names = {**function.__globals__, **dict(parts), **bound_rows}
    bound = FunctionType(function.__code__, names, function.__name__)
    bound.__module__, bound.__qualname__ = function.__module__, function.__qualname__
    bound.__doc__ = function.__doc__
    return bound


def _rows_in(template: Function, parts: Mapping[str, Function]) -> dict[str, Function]:
    """Return the row templates that a template names, or to which its free names are bound."""
    function = cast(FunctionType, template)
    known = {**function.__globals__, **parts}
    named = {name: known[name] for name in function.__code__.co_names if name in known}
    return {name: each for name, each in named.items() if is_row_template(each)}


def _free_names(template: Function, parts: Mapping[str, Function]) -> Iterator[str]:
    yield from cast(FunctionType, template).__code__.co_names
    for each in _rows_in(template, parts).values():
        yield from _free_names(each, parts)
