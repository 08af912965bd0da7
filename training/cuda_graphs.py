"""Work on tensors of a GPU as CUDA graphs: all its kernels in one launch."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import torch
from torch import Tensor

Work = Callable[..., tuple[Tensor, ...]]
"""Takes tensors and returns tensors; without a number that the CPU waits for."""

WARM_UP = 3
"""Calls before a graph is recorded, in which libraries choose their algorithms."""


class Graphed:
    """A function of tensors, recorded once for each of their shapes and then replayed.

    What it returns is overwritten by the next call. `changed` are the tensors that it changes in
    their places, as parameters: recording leaves them as they were.

    Source: the documentation of PyTorch, CUDA semantics, whole-network capture.
    """

    def __init__(self, work: Work, changed: Sequence[Tensor]) -> None:
        self._work, self._changed = work, changed
        self._recorded: dict[tuple[torch.Size, ...], _Recording] = {}

    def __call__(self, *given: Tensor) -> tuple[Tensor, ...]:
        """What the function returns for these tensors."""
        shapes = tuple(each.shape for each in given)
        if shapes not in self._recorded:
            self._recorded[shapes] = self._record(given)
        graph, taken, returned = self._recorded[shapes]
        for there, here in zip(taken, given, strict=True):
            there.copy_(here)
        graph.replay()
        return returned

    def _record(self, given: Sequence[Tensor]) -> "_Recording":
        taken, kept = ([each.clone() for each in some] for some in (given, self._changed))
        with _aside(torch.cuda.Stream()):  # type: ignore[no-untyped-call]
            for _ in range(WARM_UP):
                self._work(*taken)
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph):
            returned = self._work(*taken)
        with torch.no_grad():
            for there, before in zip(self._changed, kept, strict=True):
                there.copy_(before)
        return graph, taken, returned


class Repeated:
    """Work that goes on from call to call, on tensors that stay where they are.

    It is recorded after the first calls, and then replayed; all calls are within `aside`.
    """

    def __init__(self, work: Callable[[], None], before: Callable[[], None]) -> None:
        """`before` is what the CPU does before each call, which is no part of the graph."""
        self._work, self._before, self._n_calls = work, before, 0
        self._stream = torch.cuda.Stream()  # type: ignore[no-untyped-call]
        self._graph: torch.cuda.CUDAGraph | None = None

    @contextmanager
    def aside(self) -> Iterator[None]:
        """In the stream that the work is recorded in: to change it amid a recording is an error."""
        with _aside(self._stream):
            yield

    def __call__(self) -> None:
        """Do the work once more."""
        self._before()
        self._n_calls += 1
        if self._n_calls <= WARM_UP:
            self._work()
            return
        if self._graph is None:
            graph = torch.cuda.CUDAGraph()
            with torch.cuda.graph(graph, stream=self._stream):
                self._work()
            self._graph = graph
        self._graph.replay()


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


@contextmanager
def _aside(stream: torch.cuda.Stream) -> Iterator[None]:
    """In another stream, after what this one was asked to do; later work waits for it."""
    usual = torch.cuda.current_stream()
    stream.wait_stream(usual)
    with torch.cuda.stream(stream):
        yield
    usual.wait_stream(stream)


_Recording = tuple[torch.cuda.CUDAGraph, list[Tensor], tuple[Tensor, ...]]
