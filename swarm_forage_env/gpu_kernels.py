"""How kernels of a GPU are compiled and launched by numba-cuda.

A GPU fetches machine code more slowly than it runs it, so that a kernel has each loop once. Python
prepares an argument of a launch only if it differs from the one before: a launch of
thirty arrays takes numba-cuda a quarter of a millisecond.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from threading import Lock
from typing import Any

_SWITCH = Lock()
"""Held while what numba-cuda calls to make PTX is another function."""

GPU_OPTIONS = {"lto": False}
"""What numba-cuda compiles with: where it optimises as it links, it fuses products and sums."""

LABEL = re.compile(r'"?([\w.$-]+)"?:')
BRANCH = re.compile(r"\s+br .*label ")
TARGET = re.compile(r'label %"?([\w.$-]+)"?')

EXTREME = re.compile(
    r'\s+%"(?P<to>[^"]+)" = call (?P<kind>\w+) @"__nv_f(?P<name>max|min)f?"'
    r"\(\w+ +(?P<one>\S+), \w+ +(?P<other>\S+)\)"
)

LOOP, ONCE = "!9000001", "!9000002"
"""Numbers of what marks a loop in LLVM's text."""


@contextmanager
def compiled_for_gpu() -> Iterator[None]:
    """What is compiled for a GPU meanwhile has each loop once, and the numbers of a CPU.

    Numba's decorator has no option for either, but what it calls to make PTX takes LLVM's text and
    whether a product and a sum are rounded each.
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
    """LLVM's text of functions, in which no loop may be unrolled and `max` and `min` are Python's.

    A loop ends with a branch back: to a block that stands before it in its function. Of two zeros
    of unlike signs Python takes the first one, and a GPU the positive one.

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
    """The larger or the smaller of two numbers: the second one if it is, else the first."""
    order = "ogt" if name == "max" else "olt"  # codespell:ignore
    is_other = f'%"{to}.is_other"'
    return (
        f"  {is_other} = fcmp {order} {kind} {other}, {one}\n"
        f'  %"{to}" = select i1 {is_other}, {kind} {other}, {kind} {one}'
    )


class PreparedKernel:
    """A kernel that is launched on the same arrays again and again.

    kernel[blocks, threads, stream](*arguments)
    """

    def __init__(self, dispatcher: Any) -> None:  # noqa: ANN401 numba-cuda's
        self.dispatcher = dispatcher
        self._compiled: Any = None
        self._words: list[_Words] = []

    def __getitem__(self, launch: tuple[Any, ...]) -> Callable[..., None]:
        """The kernel on a grid, and in a stream."""
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
    """The words that a kernel is handed for one of its arguments, an array or a number."""

    def __init__(self, dispatcher: Any, compiled: Any, kind: Any) -> None:  # noqa: ANN401
        from numba.cuda import types

        self.words: list[object] = []
        self._kernel, self._compiled, self._kind = dispatcher, compiled, kind
        self._given: object = None
        self._is_number = isinstance(kind, types.Number)
        is_tuple = isinstance(kind, types.BaseTuple)
        self._parts = [_Words(dispatcher, compiled, each) for each in kind] if is_tuple else []

    def fits(self, given: Any) -> bool:  # noqa: ANN401 an array, a number or a tuple of them
        """Whether the kernel is compiled for an argument of this type; its words are made."""
        if given is self._given and not self._is_number:
            return True
        if self._parts:
            if not all(map(_Words.fits, self._parts, given)):
                return False
            self.words = [word for part in self._parts for word in part.words]
        else:
            if not self._is_number and self._kernel.typeof_pyval(given) != self._kind:
                return False
            self.words = []
            self._compiled._prepare_args(self._kind, given, 0, [], self.words)
        self._given = given
        return True
