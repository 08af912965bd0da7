"""Fields of records that policies observe or write: their layout, and copies to and from rows.

A `FieldPath` locates a field of a record. Values are copied between the records of a robot and a
row of an observation or action, in spans of float32 words.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle, product
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Int64, UInt64
from swarm_forage_env.compiler import inlined
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.record import Field, Record, RecordType, offset_of
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.templates import row_template

lane: Kernel
lanes: Kernel
first_world: Kernel
end_world: Kernel
"""Free names of the templates: lanes."""

Sizes = Mapping[str, int]
"""Sizes of named axes, as in slots=4."""

Words = Float32[Array, "worlds words"]
"""Records of the robots of some worlds, viewed as float32 words."""

Spans = UInt64[Array, "spans 4"]
"""Spans of words: index of the array of records, first word in a robot's record, number of words,
and first element in the row. Unsigned, because signed indices are checked for negative values,
which makes copying five times as slow."""


@dataclass(frozen=True)
class FieldPath:
    """Location of a field of a record."""

    part: str
    """Part of an observation, with which its name begins: `encounter`; empty: none."""
    source: str
    """Path of its record: `robots.readings`, `minds.estimator.situation`."""
    record: type[Record]
    name: str
    label: str = ""
    """Name in the part; empty: the name that the field declares."""
    each: str = ""
    """Named axis along which a robot has several records; empty: it has one record."""

    @property
    def field(self) -> Field:
        """Declaration of the field in its record."""
        return self.record.fields[self.name]

    @property
    def shown_as(self) -> str:
        """Name in the part."""
        return self.label or self.field.label or self.name

    def shape(self, sizes: Sizes) -> tuple[int, ...]:
        """Return the shape of the field of one robot."""
        axes = (*([self.each] if self.each else []), *self.field.shape)
        return tuple(sizes[axis] if isinstance(axis, str) else axis for axis in axes)

    def features(self, sizes: Sizes, scenario: BaseScenario | None) -> Iterator[Feature]:
        """Yield the feature of each element of the field in a scenario."""
        each, shape = self.field, self.shape(sizes)
        numbered = shape[: len(shape) - len(each.names)]
        axes = (*(map(str, range(n)) for n in numbered), *each.names)
        properties = (each.unit.split(", "), each.low, each.high, each.noise, each.scale)
        values = zip(*(_cycled(value, scenario) for value in properties), strict=True)
        for ends, value in zip(product(*axes), values, strict=False):
            yield Feature(".".join(filter(None, (self.part, self.shown_as, *ends))), *value)


def paths(part: str, source: str, record: type[Record], names: str) -> tuple[FieldPath, ...]:
    """Return the fields of a record with these names, which are separated by spaces."""
    return tuple(FieldPath(part, source, record, name) for name in names.split())


def _cycled(value: object, scenario: BaseScenario | None) -> Iterator[Any]:
    """Return an endless iterator of one value, or of one value for each component in turn."""
    known = value(scenario) if callable(value) else value
    parts = known if isinstance(known, list | tuple) else [known]
    return cycle([part(scenario) if callable(part) else part for part in parts])


class FieldLayout(Layout):
    """A layout of features that are fields of records."""

    paths: tuple[FieldPath, ...]
    sizes: Sizes

    def __new__(
        cls, features: Iterable[Feature], paths: Sequence[FieldPath], sizes: Sizes
    ) -> "FieldLayout":
        """Create the layout of these features, which are the elements of these fields in order."""
        layout = super().__new__(cls, features)
        layout.paths, layout.sizes = tuple(paths), dict(sizes)
        return layout

    def __getnewargs__(self) -> tuple[object, ...]:
        return tuple(self), self.paths, self.sizes

    def columns(self, part: str) -> dict[str, slice]:
        """Return the columns of each field of a part, by its name in the part."""
        return {path.shown_as: span for path, span in self._spans() if path.part == part}

    def matrix(self, records: Mapping[str, Array]) -> Float32[Array, "rows numbers"]:
        """Return the observations, in SI units, of robots with these records, given by name."""
        columns = []
        for path, _ in self._spans():
            shape = path.shape(self.sizes)
            column = records[path.source.rpartition(".")[2]][path.name]
            columns.append(column[:, : shape[0]] if shape else column)
        return np.concatenate([each.reshape(len(each), -1) for each in columns], axis=1)

    def _spans(self) -> Iterator[tuple[FieldPath, slice]]:
        start = 0
        for path in self.paths:
            stop = start + int(np.prod(path.shape(self.sizes), dtype=int))
            yield path, slice(start, stop)
            start = stop


def layout_of(
    paths: Sequence[FieldPath], sizes: Sizes, scenario: BaseScenario | None
) -> FieldLayout:
    """Return the layout of these fields in a scenario."""
    features = (each for path in paths for each in path.features(sizes, scenario))
    return FieldLayout(features, paths, sizes)


def spans_of(layout: FieldLayout, dtypes: Mapping[str, RecordType]) -> Spans:
    """Return the spans of a layout in records of these types, indexed in the order of `dtypes`."""
    spans, names, to = [], list(dtypes), 0
    for path in layout.paths:
        name, *rest = path.source.split(".")
        dtype, at = dtypes[name], 0
        for each in (*rest, path.name):
            at += offset_of(dtype, each)
            dtype = dtype[each]
        if dtype.base != np.float32:
            raise ConfigError(f"{path.source}.{path.name}: must be float32, to be observed")
        n_records = layout.sizes[path.each] if path.each else 1
        count = int(np.prod(path.shape(layout.sizes), dtype=int)) // n_records
        for k in range(n_records):
            spans.append((names.index(name), at // 4 + k * dtypes[name].itemsize // 4, count, to))
            to += count
    return _joined(spans)


def _joined(spans: Sequence[tuple[int, int, int, int]]) -> Spans:
    """Join consecutive spans that are contiguous in memory."""
    joined: list[list[int]] = []
    for source, at, count, to in spans:
        before = joined[-1] if joined else None
        if before and before[0] == source and before[1] + before[2] == at:
            before[2] += count
        else:
            joined.append([source, at, count, to])
    return np.array(joined, np.uint64).reshape(-1, 4)


def words_of(records: Array) -> Words:
    """Return a view of the records of robots as float32 words."""
    return records.view(np.float32).reshape(len(records), -1)


Fields = tuple[Words, Words, Words, Spans, int]
"""Location of the fields of a layout: words of the robots, of their minds, and of another array of
the task (or of the robots again); their spans; and the number of robots in a world."""


def source_of_its_own(layout: FieldLayout) -> str:
    """Return the further array of the task with fields of a layout; `robots` if there is none."""
    sources = [path.source.split(".")[0] for path in layout.paths]
    source, *more = {*sources} - {"robots", "minds"} or {"robots"}
    if more:
        raise ConfigError(
            f"observed fields: lie in the arrays {sorted({source, *more})}; only one array can be"
            " read in addition to robots and minds"
        )
    return source


@row_template
def read_fields(
    fields: Fields, w: int, indices: Int64[Array, " some"], rows: Float32[Array, "some numbers"]
) -> None:
    """Write the fields of these robots of world w to the first elements of rows."""
    robots, minds, others, spans, n_robots = fields
    for s in range(spans.shape[0]):
        words = robots if spans[s, 0] == 0 else minds if spans[s, 0] == 1 else others
        size = np.uint64(words.shape[1]) // np.uint64(n_robots)
        start, count, to = spans[s, 1], spans[s, 2], spans[s, 3]
        for j in range(lane(), indices.shape[0], lanes()):
            at = np.uint64(indices[j]) * size + start
            for k in range(count):
                rows[j, to + k] = words[w, at + k]


@inlined
def write_fields(row: Float32[Array, " numbers"], fields: Fields, w: int, i: int) -> None:
    """Write a row to the fields of robot i of world w."""
    robots, minds, others, spans, n_robots = fields
    for s in range(spans.shape[0]):
        words = robots if spans[s, 0] == 0 else minds if spans[s, 0] == 1 else others
        size = np.uint64(words.shape[1]) // np.uint64(n_robots)
        at = np.uint64(i) * size + spans[s, 1]
        for k in range(spans[s, 2]):
            words[w, at + k] = row[spans[s, 3] + k]


def write_rows(
    rows: Float32[Array, "worlds some numbers"],
    fields: Fields,
    robots: Int64[Array, " some"],
    span: tuple[int, int],
) -> None:
    """Write rows to the fields of some robots of every world."""
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        for k in range(lane(), robots.shape[0], lanes()):
            write_fields(rows[w, k], fields, w, robots[k])
