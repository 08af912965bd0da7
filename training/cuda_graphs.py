"""Work on tensors of a GPU as CUDA graphs, all its kernels in one launch; and its precision."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

import torch
from torch import Tensor

ReturnedT = TypeVar("ReturnedT")

WARM_UP = 3
"""Calls before a graph is recorded, in which libraries choose their algorithms."""


class Repeated(Generic[ReturnedT]):
    """Work that goes on from call to call, on tensors that stay where they are.

    It is recorded after the first calls, and then replayed; all calls are within `aside`. What it
    is given is copied, and always has the same shapes; what it returns is overwritten by the next
    call. It may wait for no number of the GPU.

    Source: the documentation of PyTorch, CUDA semantics, whole-network capture.
    """

    def __init__(
        self, work: Callable[..., ReturnedT], before: Callable[[], None] | None = None
    ) -> None:
        """`before` is what the CPU does before each call, which is no part of the graph."""
        self._work, self._before, self._n_calls = work, before, 0
        self._stream = torch.cuda.Stream()  # type: ignore[no-untyped-call]
        self._taken: list[Tensor] = []
        self._recorded: tuple[torch.cuda.CUDAGraph, ReturnedT] | None = None

    @contextmanager
    def aside(self) -> Iterator[None]:
        """In the stream that the work is recorded in: to change it amid a recording is an error.

        Later work in the usual stream waits for it.
        """
        usual = torch.cuda.current_stream()
        self._stream.wait_stream(usual)
        with torch.cuda.stream(self._stream):
            yield
        usual.wait_stream(self._stream)

    def __call__(self, *given: Tensor) -> ReturnedT:
        """Do the work once more."""
        if self._before:
            self._before()
        self._taken = self._taken or [each.clone() for each in given]
        for there, here in zip(self._taken, given, strict=True):
            there.copy_(here)
        self._n_calls += 1
        if self._n_calls <= WARM_UP:
            return self._work(*self._taken)
        if self._recorded is None:
            graph = torch.cuda.CUDAGraph()
            with torch.cuda.graph(graph, stream=self._stream):
                returned = self._work(*self._taken)
            self._recorded = graph, returned
        graph, returned = self._recorded
        graph.replay()
        return returned


@contextmanager
def in_tf32() -> Iterator[None]:
    """Within it, products of matrices take the first 10 bits of a mantissa, as tensor cores do.

    That holds for all of torch, so it is set for as long as a learner works, and then set back.
    """
    before = torch.get_float32_matmul_precision()
    torch.set_float32_matmul_precision("high")
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)
