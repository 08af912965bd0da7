"""Where worlds run: what an environment asks of a CPU or a GPU, and the worlds of a CPU."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import DTypeLike

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import bind, typed_once
from swarm_forage_env.interface import Kernel
from swarm_forage_env.no_layers import has_estimators
from swarm_forage_env.observed_fields import (
    FieldLayout,
    Fields,
    source_of_its_own,
    spans_of,
    words_of,
)


class PlacedArray(Protocol):
    """An array where worlds run: of NumPy on a CPU, of numba on a GPU."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Its axes."""
        ...

    @property
    def dtype(self) -> np.dtype[Any]:
        """What its elements are."""
        ...

    def __getitem__(self, index: Any, /) -> Any:  # noqa: ANN401 an element, or a view
        """An element, or a view."""
        ...


class Memory(Protocol):
    """Where the arrays lie of worlds that run: copies arrays to and from there."""

    @property
    def stream(self) -> int:
        """The address of the stream of CUDA in whose order it works; 0: the default stream."""
        ...

    def change_stream(self, address: int) -> None:
        """Go on in the stream of an address."""
        ...

    def to_device(self, array: Array) -> PlacedArray:
        """A copy of an array there; on a CPU the array itself, contiguous."""
        ...

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike) -> PlacedArray:
        """A new array there."""
        ...

    def write(self, there: Any, array: Array) -> None:  # noqa: ANN401 a PlacedArray of its own
        """Copy an array into one there."""
        ...

    def read(self, there: Any) -> Array:  # noqa: ANN401 as above
        """The array in the memory of the CPU: a GPU makes a copy, and is waited for."""
        ...

    def lend(self, there: Any) -> PlacedArray:  # noqa: ANN401 as above
        """The array to be handed out: a CPU makes a copy, of a GPU's the receiver writes none."""
        ...


class Place(Protocol):
    """The worlds of a loop where they run."""

    @property
    def memory(self) -> Memory:
        """A `HostMemory` or a `DeviceMemory`."""
        ...

    @property
    def arrays(self) -> Mapping[str, Any]:
        """Records by name: `robots`, `worlds`, `minds` (what the estimators keep), `earned`."""
        ...

    @property
    def estimators(self) -> Any:  # noqa: ANN401 a PlacedArray, or None
        """What the estimators keep; None where no robot has one."""
        ...

    def kernel(self, template: Kernel, functions: Mapping[str, Kernel]) -> Callable[..., None]:
        """A template over worlds, whose last argument, the first of them and the last + 1, it is
        given here."""
        ...

    def fields(self, layout: FieldLayout) -> Fields:
        """Where the fields of a layout lie, for `read_fields` and `write_fields`."""
        ...


class HostMemory:
    """The `Memory` of a CPU: nothing is copied that lies as kernels want it."""

    stream = 0

    def change_stream(self, address: int) -> None:
        """Do nothing: every call of a CPU waits for the one before."""

    def to_device(self, array: Array) -> Array:
        """The array, contiguous."""
        return np.ascontiguousarray(array)

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike) -> Array:
        """A new array."""
        return np.empty(shape, dtype)

    def write(self, there: Array, array: Array) -> None:
        """Copy an array into another."""
        there[...] = array

    def read(self, there: Array) -> Array:
        """The array itself."""
        return there

    def lend(self, there: Array) -> Array:
        """A copy."""
        return there.copy()


class WorldsOnCpu:
    """The worlds of a block and the minds of their robots, in a CPU's memory."""

    memory = HostMemory()

    def __init__(self, world: Any, minds: Array) -> None:  # noqa: ANN401 a World, from the floor above
        self._block, self._minds = world, minds

    @property
    def arrays(self) -> Mapping[str, Array]:
        """Records by name: `robots`, `worlds`, `minds` (what the estimators keep), `earned`."""
        block, estimators = self._block, self.estimators
        minds = self._minds if estimators is None else estimators
        records = {"robots": block.robots, "worlds": block.worlds, "minds": minds}
        return {**records, "earned": block.earned}

    @property
    def estimators(self) -> Array | None:
        """What the estimators keep, worlds by robots; None where no robot has one."""
        return self._minds["estimator"] if has_estimators(self._minds) else None

    def kernel(self, template: Kernel, functions: Mapping[str, Kernel]) -> Callable[..., None]:
        """A template over worlds, whose last argument it is given here."""
        compiled = typed_once(bind(template, functions))

        def run(*arguments: object) -> None:
            self._on_all_threads(lambda first, last: compiled(*arguments, (first, last)))

        return run

    def _on_all_threads(self, work: Callable[[int, int], None]) -> None:
        """Do a piece of work on all worlds, from the first one to the last + 1: on this thread."""
        work(0, self._block.n_worlds)

    def fields(self, layout: FieldLayout) -> Fields:
        """Where the fields of a layout lie, for `read_fields` and `write_fields`."""
        own = source_of_its_own(layout)
        arrays = {"robots": self._block.robots, "minds": self._minds}
        arrays.setdefault(own, getattr(self._block, own))
        spans = spans_of(layout, {name: each.dtype for name, each in arrays.items()})
        robots, minds, *_ = words = [words_of(each) for each in arrays.values()]
        return robots, minds, words[list(arrays).index(own)], spans, self._block.n_robots
