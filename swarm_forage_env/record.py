"""Records: classes of documented fields from which NumPy's structured dtypes are made.

State is kept in structured arrays, one element a robot. A compiled function receives a single
record by reference and reads and writes its fields as attributes; Python reads whole columns,
`robots["pose"]`. With the compiler switched off the same functions run on `numpy.record`.

Of a field of several numbers, booleans are int8: numba refuses nested boolean arrays. Numba would
take a record for a subtype of one that its columns begin with, and warn of it: what a subclass adds
stands in front.
"""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from swarm_forage_env.arrays import Array

RecordType = np.dtype[np.void]
"""The dtype of records."""

Rows: TypeAlias = np.recarray[tuple[int, ...], RecordType]
"""Records, a row for each robot: `rows.own_p` is a column."""

Numbers = Any
"""A record of parameters, whose fields are those of the part that it belongs to."""


Bound = float | Callable[..., float]
"""A number, or a function of a scenario."""

Noise = str | Callable[..., str]
"""A text, or a function of a scenario."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a record.

    Of a field with several components along its last axis, `unit`, `scale`, `low` and `high` may
    differ: a unit `m, rad`, a tuple of numbers.
    """

    kind: "type[np.generic | Record] | RecordType"
    """A NumPy scalar type, or the class or the dtype of a nested record."""
    shape: tuple[int | str, ...]
    """Axes of the field; one that is named (`slots`) gets its size with the dtype."""
    unit: str = ""
    """SI, or what the number is."""
    scale: Bound | tuple[Bound, ...] | None = None
    """Typical size in that unit; None: the bounds are typical."""
    low: Bound | tuple[Bound, ...] = -math.inf
    high: Bound | tuple[Bound, ...] = math.inf

    names: tuple[Sequence[str], ...] = ()
    """Names along each axis; without them, numbers."""
    label: str = ""
    """Its name in an observation; empty: that of the field."""
    noise: Noise | tuple[Noise, ...] = ""
    """How it differs from the truth, for what is measured."""
    start: float | tuple[float, ...] = 0.0
    """Value before anything has happened: a number, or one for each of the field's."""


def field(
    kind: "type[np.generic | Record] | RecordType",
    *shape: int | str,
    **about: Any,  # noqa: ANN401 the fields of `Field`
) -> Any:  # noqa: ANN401 the annotation says what it is
    """A field of a `Record`: its type, its shape, and what `Field` says of an observation of it."""
    return Field(kind, shape, **about)


def flag(*shape: int | str, **about: Any) -> Any:  # noqa: ANN401 as above
    """A field of flags that layers see: 0 or 1, float32."""
    return field(np.float32, *shape, unit="0 or 1", low=0.0, high=1.0, **about)


class Record:
    """Base of all records: subclasses list their fields as `name: type = field(...)`."""

    fields: ClassVar[Mapping[str, Field]] = {}
    """All fields by name, as they lie in memory: those of base classes last."""

    def __init_subclass__(cls) -> None:
        own = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        cls.fields = {**own, **{name: each for name, each in cls.fields.items() if name not in own}}

    @classmethod
    def dtype(cls, **sizes: int) -> RecordType:
        """The structured dtype; `sizes` are those of named axes, as slots=4."""
        columns = [(name, *_column(each, sizes)) for name, each in cls.fields.items()]
        return _the_one(np.dtype(columns, align=True))

    @classmethod
    def array(cls, shape: tuple[int, ...], **sizes: int) -> Array:
        """A structured array in which every field has its first value."""
        records = np.zeros(shape, cls.dtype(**sizes))
        cls.restart(records)
        return records

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
def _first_bytes(kind: type[Record], dtype: RecordType) -> Array | None:
    """A record at its start, as bytes; None where records have fields beside those of the class.

    To copy it is ten times as fast as to write every field.
    """
    if set(dtype.names or ()) != set(kind.fields):
        return None
    first = np.zeros(1, dtype)
    kind._restart_fields(first)
    return first.view(np.dtype((np.void, dtype.itemsize)))


def _column(
    each: Field, sizes: Mapping[str, int]
) -> tuple[type[np.generic] | RecordType, tuple[int, ...]]:
    shape = tuple(sizes[axis] if isinstance(axis, str) else axis for axis in each.shape)
    if isinstance(each.kind, type) and issubclass(each.kind, Record):
        return each.kind.dtype(**sizes), shape
    return each.kind, shape


def record_dtype(columns: Sequence[tuple[str, DTypeLike]]) -> RecordType:
    """The dtype of a record, with the columns added last, as by a subclass, in front."""
    return _the_one(np.dtype([*reversed(columns)], align=True))


def offset_of(record: RecordType, name: str) -> int:
    """Where a field of a record begins [bytes]."""
    assert record.fields is not None
    return int(record.fields[name][1])


@cache
def _the_one(dtype: RecordType) -> RecordType:
    """The first of all equal dtypes: numba compares others field by field at every call."""
    return dtype


def numbers_record(**numbers: ArrayLike) -> RecordType:
    """The dtype of a record of parameters: float64, each in the shape of its value.

    Its last column says where it ends, so that no such record begins with all of another's columns.
    """
    columns = [(name, np.float64, np.shape(value)) for name, value in numbers.items()]
    return _the_one(np.dtype([*columns, ("end", np.int8)], align=True))


def one_record(numbers: Mapping[str, ArrayLike]) -> Array:
    """A structured array of one record of parameters."""
    record = np.zeros(1, numbers_record(**numbers))
    for name, value in numbers.items():
        record[name] = value
    return record


def copied_rows(records: Array, path: Sequence[str]) -> Any:  # noqa: ANN401 Rows, or an array
    """A copy of a field of nested records, with a row for each record of every world."""
    for name in path:
        records = records[name]
    copied = records.reshape(-1, *records.shape[2:]).copy()
    return copied if copied.dtype.names is None else copied.view(np.recarray)


def rows(records: Array) -> Rows:
    """A view with a row for each record of every world; `rows(robots).pose` is a column."""
    return records.reshape(-1).view(np.recarray)
