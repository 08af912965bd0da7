"""Where worlds run: what an environment asks of a CPU or a GPU, and the worlds of a CPU."""

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
"""Where worlds run."""

ROBOTS_FOR_THREADS = 2000
"""From how many robots on several threads look through a block sooner than one (measured)."""


def checked_device(device: str) -> Device:
    """The device; ConfigError for one on which worlds cannot run."""
    match device:
        case "cpu" | "cuda":
            return device
    raise ConfigError(f"device={device!r}: must be 'cpu' or 'cuda'")


class PlacedArray(Protocol):
    """An array where worlds run: of NumPy on a CPU, of numba on a GPU."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Its axes."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """What its elements are."""

    def __getitem__(self, index: Any, /) -> Any:  # noqa: ANN401 an element, or a view
        """An element, or a view."""


class Memory:
    """The memory of a CPU: nothing is copied that lies as kernels want it."""

    stream = 0
    """The address of the stream of CUDA in whose order a GPU works; 0: the default stream."""

    def change_stream(self, address: object) -> None:
        """Go on in another stream: every call of a CPU waits for the one before."""

    def to_device(self, array: Array) -> PlacedArray:
        """The array where the worlds run, contiguous."""
        return np.ascontiguousarray(array)

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike) -> PlacedArray:
        """A new array where the worlds run."""
        return np.empty(shape, dtype)

    def write(self, there: Any, array: Array) -> None:  # noqa: ANN401 a PlacedArray of its own
        """Copy an array into one where the worlds run."""
        there[...] = array

    def read(self, there: Any) -> Array:  # noqa: ANN401 as above
        """The array in the memory of the CPU: the array itself, or a copy from a GPU."""
        return np.asarray(there)

    def lend(self, there: Any) -> PlacedArray:  # noqa: ANN401 as above
        """The array to be handed out: a copy, or one that its receiver must not write to."""
        return np.array(there)


class WorldsOnCpu:
    """The worlds of a block and the minds of their robots, in a CPU's memory."""

    memory: Memory = Memory()

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
        """A template over worlds, whose last argument it is given here.

        Few robots are looked through by the thread that asks: waking another takes longer.
        """
        compiled = typed_once(bind(template, functions))

        def run(*arguments: object) -> None:
            if self._block.rows < ROBOTS_FOR_THREADS:
                compiled(*arguments, (0, self._block.n_worlds))
            else:
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
