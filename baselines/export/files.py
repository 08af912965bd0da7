"""The files of an exported controller: machine code, header, example and vectors."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template

from llvmlite.binding import object_file

from baselines.export.robot import ExportedRobot
from swarm_forage_env.arrays import Array
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.envs.pilot import READ_ONLY_ARRAYS
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.record import Field, RecordType, offset_of
from swarm_forage_env.targets import TARGETS, compiled_for

N_TICKS, SEEDS = 1000, range(10)
"""Length of the vectors (100 s); seeds of the worlds of which the busiest robot is recorded."""

CHIP = {"flash": 1024 * 1024, "ram": 192 * 1024}
"""Memory of an STM32F407, the chip of the e-puck 2 [bytes]."""

C_TYPES = {"int8": "int8_t", "int32": "int32_t", "float32": "float", "float64": "double"}

CLEAR_MESSAGE = """\
    memset(self->minds + self->number * CONTROLLER_MIND_SIZE + CONTROLLER_MESSAGE, 0,
           CONTROLLER_PAYLOAD_SIZE);
"""
"""Zeros for what a message does not tell of. The words of a policy last until its next decision."""

ABOUT_MESSAGE = """\
/* What robots tell of the nest [0] and of the prey area [1]: has_estimate, 1 if of it, else zeros;
 * its distance and direction in the body frame of the sender; p, its inverse confidence. */"""

BYTES_A_LINE = 20

COMPILE = {  # command that compiles the example, by target
    "x86-64": "cc -O2 example.c controller.o -o example && ./example",
    "cortex-a": "aarch64-linux-gnu-gcc -O2 example.c controller.o -o example && ./example",
    "wasm32": "zig cc -target wasm32-wasi -O2 example.c controller.o -o example.wasm",
    "cortex-m4": (
        "arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -mfloat-abi=softfp -mfpu=fpv4-sp-d16 -O2 \\\n"
        "    example.c controller.o STARTUP.c --specs=rdimon.specs -T BOARD.ld -lm -o example.elf"
    ),
}


@dataclass(frozen=True)
class Weight:
    """Memory that an exported controller needs [bytes]."""

    code: int  # machine code and its constants
    data: int  # parameters of the layers, such as weights of a network
    ram: int  # state of a robot, without its stack


ARGOS_ROWS = """\
| `argos_controller.cpp` | the controller in C++ for ARGoS 3, linked to the machine code |
| `experiment.argos` | the experiment: arena, robots and noise |
| `floor.png` | the floor of its arena |
"""
"""Rows of the README on the files for ARGoS."""


def export(exported: ExportedRobot, target: str, folder: Path, argos: bool = False) -> Weight:
    """Write the controller of one robot for a target; ConfigError if it does not fit on the chip.

    `argos`: the README lists the files that `write_argos` adds.
    """
    content = compiled_for(TARGETS[target], exported.llvm_text())
    records = exported.records
    data = {
        "settings": records.settings,
        "first_mind": records.minds[:1],
        "first_memory": records.memories[:1],
        **{k: each for k, each in exported.policy.items() if _is_constant(k, each)},
    }
    written = [each for k, each in exported.policy.items() if not _is_constant(k, each)]
    arrays = records.robots, records.minds, records.memories, *written
    ram = sum(each.nbytes for each in arrays) + 8
    weight = Weight(_code_size(content), sum(each.nbytes for each in data.values()), ram)
    if target == "cortex-m4":
        _check_room(exported, weight)
    seed, robot = exported.busiest(SEEDS, N_TICKS)
    vectors = exported.record_vectors(seed, robot, N_TICKS)
    words = {**_words(exported, target, weight), "seed": seed, "number": robot}
    words["argos_rows"] = ARGOS_ROWS if argos else ""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("controller.h", "example.c", "README.md"):
        write_atomically(folder / name, filled(name, words).encode())
    write_atomically(folder / "controller.o", content)
    write_atomically(folder / "controller_data.h", _data(exported, data).encode())
    write_atomically(folder / "vectors.bin", vectors.tobytes())
    return weight


def filled(name: str, words: Mapping[str, object]) -> str:
    """Return a template with these words filled in."""
    text = (files("baselines.export") / "templates" / name).read_text("utf-8")
    return Template(text).substitute(words)


def _is_constant(name: str, array: Array) -> bool:
    """Return whether an array of a policy is constant; `pilot_robots` is written in each tick."""
    return name in READ_ONLY_ARRAYS and name != "pilot_robots" and array.nbytes > 0


def _of_policy(exported: ExportedRobot) -> dict[str, str]:
    """Return the C code for a policy: fields of the controller, parameters and arguments."""
    fields, parameters, arguments = [], [], []
    for name, each in exported.policy.items():
        is_constant = _is_constant(name, each)
        if not is_constant and each.nbytes:
            fields.append(f"    CONTROLLER_ALIGNAS(8) uint8_t {name}[{each.nbytes}];\n")
        parameters.append(f"{'const ' if is_constant or not each.nbytes else ''}void *{name}")
        place = f"controller_{name}" if is_constant else f"self->{name}"
        arguments.append(place if each.nbytes else "controller_settings")
    parameters += [f"void *{name}" for name in exported.views]
    arguments += [f"self->{of}" for of in exported.views.values()]
    return {
        "policy_fields": "".join(fields),
        "policy_taken": "".join(f"\n              {each}," for each in parameters),
        "policy_given": "".join(f"\n                           {each}," for each in arguments),
    }


def _words(exported: ExportedRobot, target: str, weight: Weight) -> dict[str, object]:
    scenario, (name, setup) = exported.scenario, exported.names
    return {
        "name": name,
        "scenario": setup,
        "version": version("swarm-forage"),
        "target": target,
        "tick": f"{scenario.tick:g}",
        "n_robots": exported.n_robots,
        "slots": exported.vector["received"].shape[0],
        "cruise": f"{scenario.robot.cruise_speed:g}",
        "clear_message": "" if "words" in exported.payload else CLEAR_MESSAGE,
        "payload": payload_struct(exported.payload, exported.message_dtype),
        **vars(weight),
        "compile": COMPILE[target],
        "n_ticks": N_TICKS,
        **_of_policy(exported),
    }


def payload_struct(fields: Mapping[str, Field], dtype: RecordType) -> str:
    """Return the message as a C struct, with units as comments."""
    lines = [ABOUT_MESSAGE, "typedef struct {"]
    if "words" in fields:
        lines[0] = "/* What robots tell each other: its meaning is the policy's. */"
    for name, each in fields.items():
        axes = "".join(f"[{n}]" for n in dtype[name].shape)
        unit = f" /* [{each.unit}] */" if each.unit else ""
        lines.append(f"    {C_TYPES[dtype[name].base.name]} {name}{axes};{unit}")
    return "\n".join([*lines, "} controller_payload_t;"])


def _data(exported: ExportedRobot, data: Mapping[str, Array]) -> str:
    """Return a C header with sizes and offsets of the records, and the constant records."""
    robots, minds = exported.records.robots.dtype, exported.records.minds.dtype
    heard, at = robots["heard"], offset_of(robots, "heard")
    command = offset_of(robots, "command")
    numbers = {
        "ROBOT_SIZE": robots.itemsize,
        "MIND_SIZE": minds.itemsize,
        "MEMORY_SIZE": exported.records.memories.dtype.itemsize,
        "MESSAGE": offset_of(minds, exported.message),
        "PAYLOAD_SIZE": minds[exported.message].itemsize,
        "READINGS": offset_of(robots, "readings"),
        "READINGS_SIZE": robots["readings"].itemsize,
        "HEARD": at,
        "HEARD_SIZE": heard.itemsize,
        "HEARD_N": offset_of(heard, "n"),
        "HEARD_VALID": offset_of(heard, "is_valid"),
        "HEARD_RANGE_BEARING": offset_of(heard, "range_bearing"),
        "HEARD_AVERAGED": offset_of(heard, "n_averaged"),
        "HEARD_SENDER": offset_of(heard, "sender"),
        "COMMAND_WHEELS": command + offset_of(robots["command"], "wheels"),
        "COMMAND_SPEAKING": command + offset_of(robots["command"], "is_speaking"),
        "VECTOR_SIZE": exported.vector.itemsize,
    }
    lines = ["/* Sizes and places [bytes], and records that do not change. */"]
    lines += [f"#define CONTROLLER_{name} {value}" for name, value in numbers.items()]
    for name, array in data.items():
        content = [f"0x{byte:02x}," for byte in array.tobytes()]
        kind = "CONTROLLER_ALIGNAS(8) static const uint8_t"
        lines.append(f"{kind} controller_{name}[{len(content)}] = {{")
        pieces = range(0, len(content), BYTES_A_LINE)
        lines += ["".join(content[first : first + BYTES_A_LINE]) for first in pieces]
        lines.append("};")
    return "\n".join(lines) + "\n"


def _code_size(content: bytes) -> int:
    sections = object_file.ObjectFileRef.from_data(content).sections()
    wanted = b".text", b".rodata", b".data", b"CODE", b"DATA"
    return sum(each.size() for each in sections if (each.name() or b"").startswith(wanted))


def _check_room(exported: ExportedRobot, weight: Weight) -> None:
    bytes_of = {"flash": weight.code + weight.data, "ram": weight.ram}
    for kind, n_bytes in bytes_of.items():
        if n_bytes > (capacity := CHIP[kind]):
            raise ConfigError(
                f"controller '{exported.names[0]}' needs {n_bytes} bytes of {kind} in scenario"
                f" '{exported.scenario.name}', but an STM32F407 has {capacity}; use fewer robots:"
                " --set task.n_robots=50"
            )
