"""Work on tensors of a GPU as CUDA graphs: all its kernels in one launch."""

from collections.abc import Callable, Sequence

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
        aside = torch.cuda.Stream()  # type: ignore[no-untyped-call]
        aside.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(aside):
            for _ in range(WARM_UP):
                self._work(*taken)
        torch.cuda.current_stream().wait_stream(aside)
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph):
            returned = self._work(*taken)
        with torch.no_grad():
            for there, before in zip(self._changed, kept, strict=True):
                there.copy_(before)
        return graph, taken, returned


_Recording = tuple[torch.cuda.CUDAGraph, list[Tensor], tuple[Tensor, ...]]
