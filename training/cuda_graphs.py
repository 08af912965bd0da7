"""CUDA graphs, which launch all kernels of a function at once, and the precision of products."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

import torch
from torch import Tensor

ReturnedT = TypeVar("ReturnedT")

WARM_UP = 3
"""Number of calls before a graph is recorded, in which libraries choose their algorithms."""


class GraphedFunction(Generic[ReturnedT]):
    """Function on GPU tensors at fixed addresses, recorded as a CUDA graph and replayed.

    It is recorded after the first calls; all calls must be made within `in_stream`. Arguments are
    copied and must keep their shapes; the next call overwrites the returned tensors. The function
    must not wait for values of the GPU.

    Source: the documentation of PyTorch, CUDA semantics, whole-network capture.
    """

    def __init__(
        self, work: Callable[..., ReturnedT], before: Callable[[], None] | None = None
    ) -> None:
        """Store the function; `before` runs on the CPU before each call, outside the graph."""
        self._work, self._before, self._n_calls = work, before, 0
        self._stream = torch.cuda.Stream()  # type: ignore[no-untyped-call]
        self._inputs: list[Tensor] = []
        self._recorded: tuple[torch.cuda.CUDAGraph, ReturnedT] | None = None

    @contextmanager
    def in_stream(self) -> Iterator[None]:
        """Run the block in the stream of the recording, which must not change amid a recording.

        Later work in the current stream waits for the block.
        """
        current = torch.cuda.current_stream()
        self._stream.wait_stream(current)
        with torch.cuda.stream(self._stream):
            yield
        current.wait_stream(self._stream)

    def __call__(self, *arguments: Tensor) -> ReturnedT:
        """Call the function, or replay its graph."""
        if self._before:
            self._before()
        self._inputs = self._inputs or [each.clone() for each in arguments]
        for there, here in zip(self._inputs, arguments, strict=True):
            there.copy_(here)
        self._n_calls += 1
        if self._n_calls <= WARM_UP:
            return self._work(*self._inputs)
        if self._recorded is None:
            graph = torch.cuda.CUDAGraph()
            with torch.cuda.graph(graph, stream=self._stream):
                returned = self._work(*self._inputs)
            self._recorded = graph, returned
        graph, returned = self._recorded
        graph.replay()
        return returned


@contextmanager
def in_tf32() -> Iterator[None]:
    """Compute matrix products with 10 bits of mantissa (TF32, on tensor cores) within the block.

    The setting applies to all of torch; it is restored at the end of the block.
    """
    before = torch.get_float32_matmul_precision()
    torch.set_float32_matmul_precision("high")
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)
