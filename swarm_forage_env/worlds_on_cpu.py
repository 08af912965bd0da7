"""Devices: memory and worlds of a CPU, with the interface that a GPU shares."""

from collections.abc import Callable, Mapping
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import DTypeLike

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import bind, typed_once
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import (
    FieldLayout,
    Fields,
    source_of_its_own,
    spans_of,
    words_of,
)
from swarm_forage_env.raw_control import has_estimators

Device = Literal["cpu", "cuda"]
"""Device on which worlds run."""

ROBOTS_FOR_THREADS = 10_000
"""Number of robots from which kernels other than ticks run on several threads: handing them over
ends the polling of the threads (measured)."""


def checked_device(device: str) -> Device:
    """Return the device; ConfigError if worlds cannot run on it."""
    match device:
        case "cpu" | "cuda":
            return device
    raise ConfigError(f"device={device!r}: must be 'cpu' or 'cuda'")


class PlacedArray(Protocol):
    """An array on the device of the worlds: NumPy's on a CPU, numba's on a GPU."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Size of each axis."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the elements."""

    def __getitem__(self, index: Any, /) -> Any:  # noqa: ANN401 an element, or a view
        """Return an element, or a view."""


class Memory:
    """Memory of a CPU; only arrays that are not contiguous are copied for kernels."""

    stream = 0
    """Address of the CUDA stream that a GPU uses; 0 is the default stream."""

    def change_stream(self, address: object) -> None:
        """Do nothing: on a CPU, every call waits for the one before."""

    def to_device(self, array: Array) -> PlacedArray:
        """Return the array, contiguous, on the device of the worlds."""
        return np.ascontiguousarray(array)

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike) -> PlacedArray:
        """Return a new array on the device of the worlds."""
        return np.empty(shape, dtype)

    def write(self, there: Any, array: Array) -> None:  # noqa: ANN401 a PlacedArray of its own
        """Copy an array into an array on the device of the worlds."""
        there[...] = array

    def read(self, there: Any) -> Array:  # noqa: ANN401 as above
        """Return the array in the memory of the CPU: the array itself, or a copy from a GPU."""
        return np.asarray(there)

    def lend(self, there: Any) -> PlacedArray:  # noqa: ANN401 as above
        """Return an array for a user: a copy, or on a GPU the array itself, for reading only."""
        return np.array(there)


class WorldsOnCpu:
    """Worlds of a block and minds of their robots, in the memory of a CPU."""

    memory: Memory = Memory()

    def __init__(self, world: Any, minds: Array) -> None:  # noqa: ANN401 a World, not importable
        self._block, self._minds = world, minds

    @property
    def arrays(self) -> Mapping[str, Array]:
        """Records by name: `robots`, `worlds`, `minds` (state of the estimators), `rewards`."""
        block, estimators = self._block, self.estimators
        minds = self._minds if estimators is None else estimators
        records = {"robots": block.robots, "worlds": block.worlds, "minds": minds}
        return {**records, "rewards": block.rewards}

    @property
    def estimators(self) -> Array | None:
        """State of the estimators, shape (worlds, robots); None if no robot has one."""
        return self._minds["estimator"] if has_estimators(self._minds) else None

    def kernel(self, template: Kernel, functions: Mapping[str, Kernel]) -> Callable[..., None]:
        """Return a template over worlds; its last argument, a range of worlds, is added here.

        The calling thread processes few robots alone: handing them over takes longer.
        """
        compiled = typed_once(bind(template, functions))

        def run(*arguments: object) -> None:
            if self._block.rows < ROBOTS_FOR_THREADS:
                compiled(*arguments, (0, self._block.n_worlds))
            else:
                self._on_all_threads(lambda first, last: compiled(*arguments, (first, last)))

        return run

    def _on_all_threads(self, work: Callable[[int, int], None]) -> None:
        """Call a function with the range of all worlds (first, last + 1), on this thread."""
        work(0, self._block.n_worlds)

    def fields(self, layout: FieldLayout) -> Fields:
        """Return the location of the fields of a layout, for `read_fields` and `write_fields`."""
        source = source_of_its_own(layout)
        arrays = {"robots": self._block.robots, "minds": self._minds}
        arrays.setdefault(source, getattr(self._block, source))
        spans = spans_of(layout, {name: each.dtype for name, each in arrays.items()})
        robots, minds, *_ = words = [words_of(each) for each in arrays.values()]
        return robots, minds, words[list(arrays).index(source)], spans, self._block.n_robots
