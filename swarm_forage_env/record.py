"""Records: classes of documented fields that define NumPy's structured dtypes.

State is kept in structured arrays, one element per robot. A compiled function receives a single
record by reference and reads and writes its fields as attributes; Python reads whole columns,
`robots["pose"]`. With the compiler switched off the same functions run on `numpy.record`.

Array fields of booleans are int8, as numba refuses nested boolean arrays. Numba treats a record as
a subtype of one with which its columns begin, and warns; so the fields of a subclass come first.
"""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError

RecordType = np.dtype[np.void]
"""The dtype of records."""

Rows: TypeAlias = np.recarray[tuple[int, ...], RecordType]
"""Records with a row for each robot; `rows.own_p` is a column."""

Numbers = Any
"""A record of parameters; its fields are those of the part that it belongs to."""


Bound = float | Callable[..., float]
"""A number, or a function of a scenario."""

Noise = str | Callable[..., str]
"""A text, or a function of a scenario."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a record.

    `unit`, `scale`, `low`, `high` and `noise` may differ between the components of the last axis: a
    unit `m, rad`, a tuple of bounds.
    """

    kind: "type[np.generic | Record] | RecordType"
    """A NumPy scalar type, or the class or the dtype of a nested record."""
    shape: tuple[int | str, ...]
    """Size of each axis; a named axis (`slots`) gets its size from `Record.dtype`."""
    unit: str = ""
    """SI unit, or the meaning of the value."""
    scale: Bound | tuple[Bound, ...] | None = None
    """Typical magnitude in that unit; None: the bounds are typical."""
    low: Bound | tuple[Bound, ...] = -math.inf
    high: Bound | tuple[Bound, ...] = math.inf

    names: tuple[Sequence[str], ...] = ()
    """Names of the elements along the last axes; along other axes elements are numbered."""
    label: str = ""
    """Name in an observation; empty: the name of the field."""
    noise: Noise | tuple[Noise, ...] = ""
    """Description of the measurement noise; empty for a value without noise."""
    start: float | tuple[float, ...] = 0.0
    """Initial value: one number, or one for each element of the field."""


def field(
    kind: "type[np.generic | Record] | RecordType",
    *shape: int | str,
    **about: Any,  # noqa: ANN401 the fields of `Field`
) -> Any:  # noqa: ANN401 the annotation says what it is
    """Return a field of a `Record`; `about` gives further attributes of `Field`."""
    return Field(kind, shape, **about)


def flag(*shape: int | str, **about: Any) -> Any:  # noqa: ANN401 as above
    """Return a field of flags that layers observe: 0 or 1, float32."""
    return field(np.float32, *shape, unit="0 or 1", low=0.0, high=1.0, **about)


class Record:
    """Base class of records: subclasses declare their fields as `name: type = field(...)`."""

    fields: ClassVar[Mapping[str, Field]] = {}
    """All fields by name, in memory order: those of base classes last. A subclass may replace a
    nested record by one that extends it, and no other field."""

    def __init_subclass__(cls) -> None:
        own = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        for name in own.keys() & cls.fields.keys():
            kind = cls.fields[name].kind
            if not (isinstance(kind, type) and issubclass(kind, Record)):
                raise ConfigError(
                    f"{cls.__name__}.{name}: a record that it extends has a field of this name,"
                    " which other functions use; choose another name"
                )
        cls.fields = {**own, **{name: each for name, each in cls.fields.items() if name not in own}}

    @classmethod
    def dtype(cls, **sizes: int) -> RecordType:
        """Return the structured dtype; `sizes` gives the sizes of named axes, as in slots=4."""
        columns: list[tuple[Any, ...]] = []
        for name, each in cls.fields.items():
            kind = each.kind
            if isinstance(kind, type) and issubclass(kind, Record):
                kind = kind.dtype(**sizes)
            shape = (sizes[axis] if isinstance(axis, str) else axis for axis in each.shape)
            columns.append((name, kind, tuple(shape)))
        return _the_one(np.dtype(columns, align=True))

    @classmethod
    def array(cls, shape: tuple[int, ...], **sizes: int) -> Array:
        """Return a structured array in which every field has its initial value."""
        records = np.zeros(shape, cls.dtype(**sizes))
        cls.restart(records)
        return records

    @classmethod
    def restart(cls, records: Array) -> None:
        """Set every field of a structured array to its initial value, in place."""
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
    """Return an initial record as bytes; None if the fields of dtype and class differ.

    Copying it is ten times as fast as writing every field.
    """
    if set(dtype.names or ()) != set(kind.fields):
        return None
    first = np.zeros(1, dtype)
    kind._restart_fields(first)
    return first.view(np.dtype((np.void, dtype.itemsize)))


def record_dtype(columns: Sequence[tuple[str, DTypeLike]]) -> RecordType:
    """Return the dtype of these columns in reverse order: the last, as of a subclass, first."""
    return _the_one(np.dtype([*reversed(columns)], align=True))


def offset_of(record: RecordType, name: str) -> int:
    """Return the offset of a field in a record [bytes]."""
    assert record.fields is not None
    return int(record.fields[name][1])


@cache
def _the_one(dtype: RecordType) -> RecordType:
    """Return the first of all equal dtypes: numba compares others field by field in each call."""
    return dtype


def numbers_record(**numbers: ArrayLike) -> RecordType:
    """Return the dtype of a record of parameters: float64, each in the shape of its value.

    Due to its last column `_end`, no such record begins with all the columns of another.
    """
    columns = [(name, np.float64, np.shape(value)) for name, value in numbers.items()]
    return _the_one(np.dtype([*columns, ("_end", np.int8)], align=True))


def one_record(numbers: Mapping[str, ArrayLike]) -> Array:
    """Return a structured array with one record of parameters."""
    record = np.zeros(1, numbers_record(**numbers))
    for name, value in numbers.items():
        record[name] = value
    return record


def copied_rows(records: Array, path: Sequence[str]) -> Any:  # noqa: ANN401 Rows, or an array
    """Return a copy of a field of nested records, with a row for each record of every world."""
    for name in path:
        records = records[name]
    copied = records.reshape(-1, *records.shape[2:]).copy()
    return copied if copied.dtype.names is None else copied.view(np.recarray)


def rows(records: Array) -> Rows:
    """Return a view with a row for each record of every world; `rows(robots).pose` is a column."""
    return records.reshape(-1).view(np.recarray)
