"""Compilation and launch of GPU kernels with numba-cuda.

A GPU fetches machine code more slowly than it runs it, so loops are not unrolled. An argument of a
launch is prepared only if it differs from that of the launch before: numba-cuda takes a quarter of
a millisecond to launch a kernel on thirty arrays.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from threading import Lock
from typing import Any

_SWITCH = Lock()
"""Lock held while the function that numba-cuda calls to make PTX is replaced."""

GPU_OPTIONS = {"lto": False}
"""Options of numba-cuda: with optimisation at link time it would fuse products and sums."""

LABEL = re.compile(r'"?([\w.$-]+)"?:')
BRANCH = re.compile(r"\s+br .*label ")
TARGET = re.compile(r'label %"?([\w.$-]+)"?')

EXTREME = re.compile(
    r'\s+%"(?P<to>[^"]+)" = call (?P<kind>\w+) @"__nv_f(?P<name>max|min)f?"'
    r"\(\w+ +(?P<one>\S+), \w+ +(?P<other>\S+)\)"
)

LOOP, ONCE = "!9000001", "!9000002"
"""Metadata that marks a loop in LLVM's text."""


@contextmanager
def compiled_for_gpu() -> Iterator[None]:
    """Compile GPU code in this context without unrolled loops, and with the results of a CPU.

    Numba's decorator has no option for either, but the function that it calls to make PTX takes
    LLVM's text and an option that disables fused products and sums.
    """
    from numba.cuda.cudadrv import nvvm

    with _SWITCH:
        usual = nvvm.compile_ir

        def compile_ir(texts: str | Sequence[str], **options: object) -> bytes:
            every = [texts] if isinstance(texts, str) else texts
            ptx: bytes = usual([*map(as_on_cpu, every)], **{**options, "fma": False})
            return ptx

        nvvm.compile_ir = compile_ir
        try:
            yield
        finally:
            nvvm.compile_ir = usual


def as_on_cpu(text: str) -> str:
    """Return LLVM's text with loop unrolling disabled, and with Python's `max` and `min`.

    A loop ends with a branch back, to an earlier block of its function. Of two zeros with different
    signs, Python takes the first one, and a GPU the positive one.

    Source: LLVM Language Reference Manual, llvm.loop.unroll.disable.
    """
    lines, before = [], set[str]()
    for line in text.split("\n"):
        marked = line
        if line.startswith("define"):
            before = set()
        elif label := LABEL.match(line):
            before.add(label[1])
        elif BRANCH.match(line) and not before.isdisjoint(TARGET.findall(line)):
            marked += f", !llvm.loop {LOOP}"
        elif extreme := EXTREME.match(line):
            marked = _compared(**extreme.groupdict())
        lines.append(marked)
    mark = f"{LOOP} = distinct !{{{LOOP}, {ONCE}}}", f'{ONCE} = !{{!"llvm.loop.unroll.disable"}}'
    return "\n".join([*lines, *mark])


def _compared(to: str, kind: str, name: str, one: str, other: str) -> str:
    """Return LLVM's text for Python's `max` or `min`, which prefer the first of equal numbers."""
    order = "ogt" if name == "max" else "olt"  # codespell:ignore
    is_other = f'%"{to}.is_other"'
    return (
        f"  {is_other} = fcmp {order} {kind} {other}, {one}\n"
        f'  %"{to}" = select i1 {is_other}, {kind} {other}, {kind} {one}'
    )


class PreparedKernel:
    """A kernel for repeated launches on the same arrays.

    kernel[blocks, threads, stream](*arguments)
    """

    def __init__(self, dispatcher: Any) -> None:  # noqa: ANN401 numba-cuda's
        self.dispatcher = dispatcher
        self._compiled: Any = None
        self._words: list[_Words] = []

    def __getitem__(self, launch: tuple[Any, ...]) -> Callable[..., None]:
        """Return the kernel on a grid and in a stream."""
        from cuda.core import LaunchConfig
        from cuda.core import launch as launch_kernel
        from numba.cuda.cudadrv.driver import _to_core_stream

        blocks, threads, stream = launch
        config = LaunchConfig(grid=blocks, block=threads)

        def run(*arguments: object) -> None:
            if not self._words or not all(map(_Words.fits, self._words, arguments)):
                self._compile(arguments)
            words = [word for each in self._words for word in each.words]
            machine_code = self._compiled._codelibrary.get_cufunc().kernel
            launch_kernel(_to_core_stream(stream), config, machine_code, *words)

        return run

    def _compile(self, arguments: Sequence[object]) -> None:
        kinds = tuple(map(self.dispatcher.typeof_pyval, arguments))
        self._compiled = self.dispatcher.compile(kinds)
        self._words = [_Words(self.dispatcher, self._compiled, kind) for kind in kinds]
        for each, argument in zip(self._words, arguments, strict=True):
            each.fits(argument)


class _Words:
    """Launch words of one argument of a kernel: an array, a number or a tuple of them."""

    def __init__(self, dispatcher: Any, compiled: Any, kind: Any) -> None:  # noqa: ANN401
        from numba.cuda import types

        self.words: list[object] = []
        self._kernel, self._compiled, self._kind = dispatcher, compiled, kind
        self._argument: object = None
        self._is_number = isinstance(kind, types.Number)
        is_tuple = isinstance(kind, types.BaseTuple)
        self._parts = [_Words(dispatcher, compiled, each) for each in kind] if is_tuple else []

    def fits(self, argument: Any) -> bool:  # noqa: ANN401 an array, a number or a tuple of them
        """Return whether the kernel accepts the type of an argument, and prepare its words."""
        if argument is self._argument and not self._is_number:
            return True
        if self._parts:
            if not all(map(_Words.fits, self._parts, argument)):
                return False
            self.words = [word for part in self._parts for word in part.words]
        else:
            if not self._is_number and self._kernel.typeof_pyval(argument) != self._kind:
                return False
            self.words = []
            self._compiled._prepare_args(self._kind, argument, 0, [], self.words)
        self._argument = argument
        return True
