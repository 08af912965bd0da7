"""Ticks for other machines, such as WebAssembly and Cortex-M4, from the same functions.

    code = compiled_for(TARGETS["wasm32"], llvm_text(loop))

Numba compiles a world and its controllers to LLVM text, which LLVM compiles for any machine. The
object code has a function `swarm_run`, in C

    int swarm_run(int64_t *nothing, void **error, void *array_0, ..., void *array_k, int64_t ticks)

which takes the arrays of `memory_of(loop)` in order, and runs the ticks of one world in place. The
resulting memory is the same as here, bit for bit (`tests/targets`). The code still calls memcpy,
memset and products of whole numbers; on a machine without float64 also its arithmetic, square root
and floor, which the linked library must round as IEEE 754 requires.
"""

import re
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
from numba.core import types
from numba.np.numpy_support import from_dtype

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import OPTIONS, bind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.loop import Loop
from swarm_forage_env.ticks import run_ticks

ENTRY = "swarm_run"
"""Name of the function in object code."""

_HOST_PATTERNS = {
    r'"(?:target-cpu|target-features|tune-cpu|probe-stack)"="[^"]*"': "",
    r"^target (?:triple|datalayout).*$": "",
    r"^(@\S+ = )common (local_unnamed_addr )?": r"\1internal ",
    r"^declare double @(?:sqrt|llvm\.sqrt\.f64)\(.*$": "",
    r"@sqrt\(": "@llvm.sqrt.f64(",
    r"\Z": "\ndeclare double @llvm.sqrt.f64(double)\n",
}
"""Patterns in LLVM's text that are specific to this machine, with their replacements."""


@dataclass(frozen=True)
class Target:
    """A kind of machine, in the names of LLVM."""

    triple: str
    cpu: str = ""
    features: str = ""
    reloc: str = "static"


TARGETS = {
    "wasm32": Target("wasm32-unknown-unknown", features="+bulk-memory"),
    "cortex-m4": Target("thumbv7em-none-eabi", cpu="cortex-m4"),
    "cortex-a": Target("aarch64-unknown-linux-gnu", reloc="pic"),
    "x86-64": Target("x86_64-unknown-linux-gnu", cpu="x86-64-v2", reloc="pic"),
}


def memory_of(loop: Loop) -> list[Array]:
    """Return copies of the arrays with the robots, layers and errors of a loop of one world.

    Padding between the fields of a record is zero, so that equal values are equal bytes.

    ConfigError for a loop of several worlds, or one that is not compiled as a whole.
    """
    layers = loop.controller.compiled
    if loop.world.n_worlds != 1 or not layers.firsts or loop.physics != "kinematic":
        raise ConfigError("code for other machines: must be of one world under physics='kinematic'")
    if loop.controller.has_rules:
        raise ConfigError(
            f"controller '{loop.controllers[0].name}': has a layer in Python, and other machines"
            " run compiled layers only; use a compiled controller, such as ssgikf"
        )
    arrays = (*loop.world.arrays, *layers.arrays, loop.world.modes, loop.world.errors)
    copies = [np.zeros(each.shape, each.dtype) for each in arrays]
    for copy, each in zip(copies, arrays, strict=True):
        copy[...] = each
    return copies


def llvm_text(loop: Loop) -> str:
    """Return LLVM's text for the ticks of a loop of one world; only `swarm_run` is public."""
    memory, n_world = memory_of(loop), len(loop.world.arrays)
    names = [f"array_{k}" for k in range(len(memory))]
    world, own = ", ".join(names[:n_world]), ", ".join(names[n_world:-2])
    call = f"called(({world},), ({own},), {names[-2]}, {names[-1]}, 0, 1, n_ticks)"
    arrays = dict(zip(names, memory, strict=True))
    return llvm_text_of(ticks_of(loop), arrays, ("n_ticks",), call)


def ticks_of(loop: Loop) -> Kernel:
    """Return `run_ticks` bound to the functions of a loop's world and controller."""
    return bind(run_ticks, {**loop.world.functions, **loop.controller.compiled.functions})


def llvm_text_of(
    called: Callable[..., object],
    arrays: Mapping[str, Array],
    numbers: Sequence[str],
    call: str,
    returns: types.Type = types.void,
    shapes: Mapping[str, str] | None = None,
) -> str:
    """Return LLVM's text for a compiled function; only `swarm_run` is public.

    `swarm_run` takes a pointer to each of `arrays`, then the 64-bit whole numbers `numbers`. It
    returns the expression `call` of these names, in which the function is named `called`. `shapes`
    gives, as expressions of the numbers, the shapes of arrays that depend on them.
    """
    shape_of = {name: str(each.shape) for name, each in arrays.items()} | dict(shapes or {})
    views = ", ".join(f"carray({name}, {shape})" for name, shape in shape_of.items())
    text = (
        f"def {ENTRY}({', '.join((*arrays, *numbers))}):\n"
        f"    {', '.join(arrays)}, = {views},\n    return {call}\n"
    )
    pointers = [types.CPointer(from_dtype(each.dtype)) for each in arrays.values()]  # type: ignore[attr-defined]
    return _llvm_text(text, called, returns(*pointers, *(types.int64 for _ in numbers)))


@cache
def _llvm_text(text: str, called: Callable[..., object], signature: Any) -> str:  # noqa: ANN401 numba's
    known: dict[str, Any] = {"carray": numba.carray, "called": called}
    exec(text, known)
    library = numba.cfunc(signature, **OPTIONS)(known[ENTRY])._library
    defined = (each.name for each in library._final_module.functions if not each.is_declaration)
    (name,) = (name for name in defined if name.startswith(f"_ZN13_3cdynamic_3e9{ENTRY}"))
    return str(library.get_llvm_str()).replace(name, ENTRY)


def compiled_for(target: Target, text: str) -> bytes:
    """Compile LLVM's text to object code that contains only what `swarm_run` needs."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(target.triple).create_target_machine(
        cpu=target.cpu, features=target.features, opt=2, reloc=target.reloc, codemodel="default"
    )
    for pattern, instead in _HOST_PATTERNS.items():
        text = re.sub(pattern, instead, text, flags=re.MULTILINE)
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name != ENTRY:
            each.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


@cache
def linked_for_web(text: str) -> bytes:
    """Link LLVM's text to a WebAssembly module, which exports `swarm_run` and its memory.

    It imports `__multi3`, the product of two 128-bit whole numbers, if the code calls it.
    ModuleNotFoundError without the package ziglang, whose linker is used.
    """
    import ziglang  # noqa: F401 fails early if it is missing

    options = "--no-entry", f"--export={ENTRY}", "--export=__heap_base", "--allow-undefined"
    with TemporaryDirectory() as folder:
        files = Path(folder) / "run.o", Path(folder) / "run.wasm"
        files[0].write_bytes(compiled_for(TARGETS["wasm32"], text))
        command = (sys.executable, "-m", "ziglang", "wasm-ld", *options, files[0], "-o", files[1])
        subprocess.run(command, check=True)
        return files[1].read_bytes()
