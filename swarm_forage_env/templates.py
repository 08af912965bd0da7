"""Templates: functions with free names, which are bound to the functions of chosen parts.

A template of a block goes over worlds and robots; it may name templates of one robot, which are
bound with it. So one text of what a robot does serves several ways to go over the robots.
"""

from collections.abc import Callable, Iterator, Mapping
from types import FunctionType
from typing import Any, TypeVar, cast

FunctionT = TypeVar("FunctionT")

Function = Callable[..., Any]

Parts = tuple[tuple[str, Function], ...]
"""The functions of chosen parts by the free names that they stand for, in order."""


def row_template(template: FunctionT) -> FunctionT:
    """Mark a template of one robot: it is bound with the template that names it."""
    cast(Any, template).is_row_template = True
    return template


def parts_of(template: Function, functions: Mapping[str, Function]) -> Parts:
    """Those functions that the template, or a template that it names, has a free name for."""
    names = set(_free_names(template))
    used = ((name, each) for name, each in functions.items() if name in names)
    return tuple(sorted(used, key=lambda part: part[0]))


def with_parts(
    template: Function, parts: Parts, compiled: Callable[[Function, Parts], Function]
) -> Function:
    """A template as a function whose free names are these parts.

    `compiled` makes a compiled function of each template of one robot that it names.
    """
    rows = {name: compiled(each, parts) for name, each in _row_templates(template).items()}
    names = {**cast(Any, template).__globals__, **rows, **dict(parts)}
    bound = FunctionType(cast(Any, template).__code__, names, template.__name__)
    bound.__module__, bound.__qualname__ = template.__module__, template.__qualname__
    bound.__doc__ = template.__doc__
    return bound


def _row_templates(template: Function) -> dict[str, Function]:
    """The templates of one robot that a template names."""
    function = cast(Any, template)
    named = {name: function.__globals__.get(name) for name in function.__code__.co_names}
    return {name: each for name, each in named.items() if hasattr(each, "is_row_template")}


def _free_names(template: Function) -> Iterator[str]:
    """The names in a template and in those that it names."""
    yield from cast(Any, template).__code__.co_names
    for each in _row_templates(template).values():
        yield from _free_names(each)
