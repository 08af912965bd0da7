"""Fields of records that policies observe or write: their layout, and copies to and from rows.

A `FieldPath` says where a field of a record lies. The numbers of a robot are copied between its
records and a row of an observation or action by spans of float32 words.
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
"""Sizes of named axes, as slots=4."""

Words = Float32[Array, "worlds words"]
"""Records of the robots of some worlds as float32 words."""

Spans = UInt64[Array, "spans 4"]
"""Which array of records, the first word in a robot's, how many, and the first number of the row
that they are copied to or from. Unsigned: a signed index costs a check that it is not negative,
and copies five times the time."""


@dataclass(frozen=True)
class FieldPath:
    """A field of a record, and where it lies."""

    part: str
    """Its part of an observation, with which its name begins: `encounter`; empty: none."""
    source: str
    """Where its record lies: `robots.readings`, `minds.estimator.situation`."""
    record: type[Record]
    name: str
    label: str = ""
    """Its name in the part; empty: as the field says."""
    each: str = ""
    """The named axis along which a robot has a record each; empty: it has one."""

    @property
    def field(self) -> Field:
        """What the record says of it."""
        return self.record.fields[self.name]

    @property
    def shown_as(self) -> str:
        """Its name in the part."""
        return self.label or self.field.label or self.name

    def shape(self, sizes: Sizes) -> tuple[int, ...]:
        """Axes of the field of one robot."""
        axes = (*([self.each] if self.each else []), *self.field.shape)
        return tuple(sizes[axis] if isinstance(axis, str) else axis for axis in axes)

    def features(self, sizes: Sizes, scenario: BaseScenario | None) -> Iterator[Feature]:
        """What each of its numbers is in a scenario."""
        each, shape = self.field, self.shape(sizes)
        numbered = shape[: len(shape) - len(each.names)]
        axes = (*(map(str, range(n)) for n in numbered), *each.names)
        said = (each.unit.split(", "), each.low, each.high, each.noise, each.scale)
        values = zip(*(_cycled(value, scenario) for value in said), strict=True)
        for ends, value in zip(product(*axes), values, strict=False):
            yield Feature(".".join(filter(None, (self.part, self.shown_as, *ends))), *value)


def paths(part: str, source: str, record: type[Record], names: str) -> tuple[FieldPath, ...]:
    """The fields of a record of these names, separated by spaces."""
    return tuple(FieldPath(part, source, record, name) for name in names.split())


def _cycled(value: object, scenario: BaseScenario | None) -> Iterator[Any]:
    """The value of each number of a field, again and again: the same, or one for each component."""
    known = value(scenario) if callable(value) else value
    parts = known if isinstance(known, list | tuple) else [known]
    return cycle([part(scenario) if callable(part) else part for part in parts])


class FieldLayout(Layout):
    """The layout of numbers that are fields of records."""

    paths: tuple[FieldPath, ...]
    sizes: Sizes

    def __new__(
        cls, features: Iterable[Feature], paths: Sequence[FieldPath], sizes: Sizes
    ) -> "FieldLayout":
        """Make the layout of these features, which are those of the fields, in order."""
        layout = super().__new__(cls, features)
        layout.paths, layout.sizes = tuple(paths), dict(sizes)
        return layout

    def __getnewargs__(self) -> tuple[object, ...]:
        return tuple(self), self.paths, self.sizes

    def columns(self, part: str) -> dict[str, slice]:
        """The columns of each field of a part, by its name in the part."""
        return {path.shown_as: span for path, span in self._spans() if path.part == part}

    def matrix(self, records: Mapping[str, Array]) -> Float32[Array, "rows numbers"]:
        """Observations in SI units of robots whose records are these, by name."""
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
    """What each number of these fields is in a scenario."""
    features = (each for path in paths for each in path.features(sizes, scenario))
    return FieldLayout(features, paths, sizes)


def spans_of(layout: FieldLayout, dtypes: Mapping[str, RecordType]) -> Spans:
    """Where the numbers of a layout lie in records of these types, in the order of `dtypes`."""
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
    """Spans of which one goes on where the one before it ended are one."""
    joined: list[list[int]] = []
    for source, at, count, to in spans:
        before = joined[-1] if joined else None
        if before and before[0] == source and before[1] + before[2] == at:
            before[2] += count
        else:
            joined.append([source, at, count, to])
    return np.array(joined, np.uint64).reshape(-1, 4)


def words_of(records: Array) -> Words:
    """Records of the robots of worlds as float32 words, in the same memory."""
    return records.view(np.float32).reshape(len(records), -1)


Fields = tuple[Words, Words, Words, Spans, int]
"""Where the numbers of a layout lie: the words of the robots, of their minds, and of one more array
of the task's own or of the robots again; spans of them; and how many robots a world has."""


def source_of_its_own(layout: FieldLayout) -> str:
    """The array of a task's own that a layout has fields of; `robots` if it has none."""
    sources = [path.source.split(".")[0] for path in layout.paths]
    own, *more = {*sources} - {"robots", "minds"} or {"robots"}
    if more:
        raise ConfigError(
            f"observed fields: lie in {sorted({own, *more})}; one array can be read"
            " beside robots and minds"
        )
    return own


@row_template
def read_fields(
    fields: Fields, w: int, which: Int64[Array, " some"], rows: Float32[Array, "some numbers"]
) -> None:
    """Write the fields of these robots of world w to the first numbers of rows."""
    robots, minds, others, spans, n_robots = fields
    for s in range(spans.shape[0]):
        words = robots if spans[s, 0] == 0 else minds if spans[s, 0] == 1 else others
        size = np.uint64(words.shape[1]) // np.uint64(n_robots)
        start, count, to = spans[s, 1], spans[s, 2], spans[s, 3]
        for j in range(lane(), which.shape[0], lanes()):
            at = np.uint64(which[j]) * size + start
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
    which: tuple[int, int],
) -> None:
    """Write rows to the fields of some robots of every world."""
    for w in range(first_world(which[0]), min(end_world(which[1]), which[1])):
        for k in range(lane(), robots.shape[0], lanes()):
            write_fields(rows[w, k], fields, w, robots[k])
