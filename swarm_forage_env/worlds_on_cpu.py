"""Where worlds run: what an environment asks of a CPU or a GPU, and the worlds of a CPU."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

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


class Place(Protocol):
    """The worlds of a loop where they run."""

    memory: Any
    """A `HostMemory` or a `DeviceMemory`."""

    @property
    def arrays(self) -> Mapping[str, Any]:
        """Records by name: `robots`, `worlds`, `minds` (what the estimators keep), `earned`."""
        ...

    @property
    def estimators(self) -> Any:  # noqa: ANN401 as above
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
    """The memory of a CPU: nothing is copied that lies as kernels want it."""

    stream = 0
    """There is no stream of CUDA: what is asked for is done when a call returns."""

    def change_stream(self, address: int) -> None:
        """Do nothing: every call of a CPU waits for the one before."""

    def to_device(self, array: Array) -> Array:
        """The array, contiguous."""
        return np.ascontiguousarray(array)

    def empty(self, shape: tuple[int, ...], dtype: Any) -> Array:  # noqa: ANN401 NumPy's
        """A new array."""
        return np.empty(shape, dtype)

    def write(self, there: Array, array: Array) -> None:
        """Copy an array into another."""
        there[...] = array

    def read(self, there: Array) -> Array:
        """The array itself."""
        return there

    def lend(self, there: Array) -> Array:
        """A copy, to be given out."""
        return there.copy()


class WorldsOnCpu:
    """The worlds of a block and the minds of their robots, in a CPU's memory."""

    memory = HostMemory()

    def __init__(self, world: Any, minds: Array) -> None:  # noqa: ANN401 of any task
        """A block of worlds; `minds` are what its running controller keeps of each robot."""
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

        def run(*arguments: Any) -> None:  # noqa: ANN401 the template's
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
