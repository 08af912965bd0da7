"""Records: classes of documented fields from which NumPy's structured dtypes are made.

State is kept in structured arrays, one element a robot. A compiled function receives a single
record by reference and reads and writes its fields as attributes; Python reads whole columns,
`robots["pose"]`. With the compiler switched off the same functions run on `numpy.record`.

Of a field of several numbers, booleans are int8: numba refuses nested boolean arrays.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, cast

import numpy as np

from swarm_forage_env.arrays import Array

Numbers = Any
"""A record of parameters, whose fields are those of the part that it belongs to."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a record."""

    kind: Any
    """A NumPy scalar type, or the class of a nested record."""

    shape: tuple[int | str, ...]
    """Axes of the field; one that is named (`slots`) gets its size with the dtype."""

    unit: str
    """SI, or what the number is."""

    scale: float
    """Typical size of the number in that unit."""

    start: Any
    """Value before anything has happened: a number, or an array of the field's shape."""


def field(
    kind: Any,  # noqa: ANN401 a scalar type or a record class
    *shape: int | str,
    unit: str = "",
    scale: float = 1.0,
    start: Any = 0.0,  # noqa: ANN401 a number or an array
) -> Any:  # noqa: ANN401 the annotation says what the attribute is
    """A field of a `Record`: its type, its shape, its unit, its typical size, its first value."""
    return Field(kind, shape, unit, scale, start)


class Record:
    """Base of all records: subclasses list their fields as `name: type = field(...)`."""

    fields: ClassVar[Mapping[str, Field]] = {}
    """All fields by name, those of base classes first."""

    def __init_subclass__(cls) -> None:
        """Collect the fields, so that `dtype` and `array` can be made."""
        own = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        cls.fields = {**cls.fields, **own}

    @classmethod
    def dtype(cls, **sizes: int) -> np.dtype[Any]:
        """The structured dtype; `sizes` are those of named axes, as slots=4."""
        columns = [(name, *_column(each, sizes)) for name, each in cls.fields.items()]
        return record_dtype(columns)

    @classmethod
    def array(cls, shape: tuple[int, ...], **sizes: int) -> Array:
        """A structured array in which every field has its first value."""
        found = np.zeros(shape, cls.dtype(**sizes))
        cls.restart(found)
        return found

    @classmethod
    def restart(cls, records: Array) -> None:
        """Give every field of a structured array its first value, in place."""
        first = _first_bytes(cast(Hashable, cls), records.dtype)
        if first is None:
            cls._restart_fields(records)
        else:
            records.view(first.dtype)[...] = first

    @classmethod
    def _restart_fields(cls, records: Array) -> None:
        for name, each in cls.fields.items():
            if isinstance(each.kind, type) and issubclass(each.kind, Record):
                each.kind.restart(records[name])
            else:
                records[name] = each.start


@cache
def _first_bytes(kind: type[Record], dtype: np.dtype[Any]) -> Array | None:
    """A record at its start, as bytes; None where records have fields beside those of the class.

    To copy it is ten times as fast as to write every field.
    """
    if set(dtype.names or ()) != set(kind.fields):
        return None
    first = np.zeros(1, dtype)
    kind._restart_fields(first)
    return first.view(np.dtype((np.void, dtype.itemsize)))


def _column(each: Field, sizes: Mapping[str, int]) -> tuple[Any, tuple[int, ...]]:
    """Type and shape of a field, as a structured dtype takes them."""
    shape = tuple(sizes[axis] if isinstance(axis, str) else axis for axis in each.shape)
    if isinstance(each.kind, type) and issubclass(each.kind, Record):
        return each.kind.dtype(**sizes), shape
    return each.kind, shape


def record_dtype(columns: list[Any]) -> np.dtype[Any]:
    """The dtype of a record, with the columns added last, as by a subclass, in front.

    Numba would take a record for a subtype of one that its columns begin with, and warn of it.
    Equal dtypes are one object: numba compares others field by field at every call of a kernel.
    """
    return _the_one(np.dtype(columns[::-1], align=True))


@cache
def _the_one(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """The first of all equal dtypes."""
    return dtype


def under_the_one_dtype(records: Array) -> Array:
    """The same records, as a view; unpickled ones have an equal dtype that is another object."""
    return records if records.dtype.names is None else records.view(_the_one(records.dtype))


def numbers_record(**numbers: Any) -> np.dtype[Any]:  # noqa: ANN401 floats or arrays of them
    """The dtype of a record of parameters: float64, each in the shape of its value."""
    columns = [(name, np.float64, np.shape(value)) for name, value in numbers.items()]
    return record_dtype(columns or [("none", np.float64, ())])


def one_record(numbers: Mapping[str, Any]) -> Array:
    """A structured array of one record of parameters."""
    found = np.zeros(1, numbers_record(**numbers))
    for name, value in numbers.items():
        found[name] = value
    return found


def rows(records: Array) -> Any:  # noqa: ANN401 a recarray, whose attributes are columns
    """A view with a row for each record of every world; `rows(robots).pose` is a column."""
    return records.reshape(-1).view(np.recarray)
