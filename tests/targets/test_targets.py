"""Ticks on other machines: the same bits as here, in all that a world and its layers keep."""

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from numba.core import config

from baselines.evaluation.experiment_config import find_layered_controller
from baselines.export.argos import floor, write_argos
from baselines.export.files import export
from baselines.export.robot import ExportedRobot
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.targets import TARGETS, compiled_for, linked_for_web, llvm_text, memory_of
from tests.columns import check_same_bits
from tests.golden.cases import ARENAS, WORLDS
from tests.networks import any_network

HERE = Path(__file__).parent
TICKS = 600
SEED = 0
"""The first world of every golden case."""

SOFT_FLOAT = {
    "__adddf3": "__aeabi_dadd",
    "__subdf3": "__aeabi_dsub",
    "__muldf3": "__aeabi_dmul",
    "__divdf3": "__aeabi_ddiv",
    "__extendsfdf2": "__aeabi_f2d",
    "__truncdfsf2": "__aeabi_d2f",
    "__floatsidf": "__aeabi_i2d",
    "__floatdidf": "__aeabi_l2d",
    "__floatundidf": "__aeabi_ul2d",
    "__floatdisf": "__aeabi_l2f",
    "__fixdfdi": "__aeabi_d2lz",
}
"""Operations on float64 of a Cortex-M4, by the names of LLVM and of ARM.

Zig's are correctly rounded. Those of GCC 12 are not: 1 - 0x1.e801a2b94bc6bp-33 is off by 0.83 ulp.
Whoever calls one function of a member of libgcc gets the others of it too, before Zig's.
"""

COMPARES = {"_arm_cmpdf2", "_arm_unorddf2"}
"""The members of libgcc with operations on float64 that are linked: comparisons round nothing."""

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="looks at machine code")


def needs(*tools):
    """Skip where Zig or another tool is missing."""
    missing = [each for each in tools if shutil.which(each) is None]
    missing += [] if importlib.util.find_spec("ziglang") else ["ziglang"]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}")


def zig(*arguments, cwd):
    """Run a command of Zig, whose package brings a linker and a correctly rounding soft float."""
    run(sys.executable, "-m", "ziglang", *arguments, cwd=cwd)


CASES = ("es1-busy/learned-both", "es1-faulty/ssgikf-sceptical")
MORE_CASES = (
    "es1-busy/ssgikf",
    "mg1-dodecagon-shadowed/ssgikf",
    "two-prey-moving/dsgiff-penalised",
    "es3/ssgikf",
)
"""Worlds and controllers of golden cases: what x86 makes of them is held by the golden data."""


@pytest.fixture(
    scope="module",
    params=[*CASES, *(pytest.param(each, marks=pytest.mark.slow) for each in MORE_CASES)],
)
def world(request):
    """The ticks of a golden case as LLVM's text, and its memory before and after."""
    name, controller = request.param.split("/")
    scenario, overrides = {**ARENAS, **WORLDS}[name]
    found = find_scenario(scenario, overrides), find_controller(controller)
    loop = Loop(*found, [SEED], "kinematic")
    text, before = llvm_text(loop), memory_of(loop)
    loop.run(TICKS)
    assert loop.world.robots["messages"].sum() > 0
    return text, before, memory_of(loop)


def padded(arrays):
    """The bytes of arrays, each on a border of 64, and how many each takes."""
    pieces = [each.tobytes() + bytes(-each.nbytes % 64) for each in arrays]
    return b"".join(pieces), [len(each) for each in pieces]


def assert_same(memory, after):
    """Assert that the bytes which came back are those of these arrays, but for padding."""
    starts = np.cumsum([0, *padded(after)[1]])
    for start, wanted in zip(starts[:-1], after, strict=True):
        found = np.frombuffer(memory, wanted.dtype, wanted.size, start).reshape(wanted.shape)
        check_same_bits(found, wanted)


def run(*command, cwd, check=True):
    """What a command prints."""
    return subprocess.run(
        command, cwd=cwd, check=check, timeout=500, text=True, capture_output=True
    ).stdout


@needs("node")
def test_web_assembly_has_the_same_bits(world, tmp_path):
    text, before, after = world
    memory, sizes = padded(before)
    (tmp_path / "memory.bin").write_bytes(memory)
    (tmp_path / "run.wasm").write_bytes(linked_for_web(text))
    files = "run.wasm", "memory.bin", "out.bin"
    run("node", HERE / "run.mjs", *files, str(TICKS), *map(str, sizes), cwd=tmp_path)
    assert_same((tmp_path / "out.bin").read_bytes(), after)


@needs("arm-none-eabi-gcc", "qemu-system-arm")
def test_a_cortex_m4_has_the_same_bits(world, tmp_path):
    text, before, after = world
    memory, sizes = padded(before)
    (tmp_path / "memory.bin").write_bytes(memory)
    (tmp_path / "run.o").write_bytes(compiled_for(TARGETS["cortex-m4"], text))
    pointers = ", ".join(f"p[{k}]" for k in range(len(sizes)))
    (tmp_path / "sizes.h").write_text(
        f"#define N_ARRAYS {len(sizes)}\n#define SIZES {str(sizes)[1:-1]}\n"
        f"#define TICKS {TICKS}\n#define ARRAYS {pointers}\n"
    )
    run_on_cortex_m4(HERE / "main.c", "run.o", cwd=tmp_path)
    assert_same((tmp_path / "out.bin").read_bytes(), after)


def run_on_cortex_m4(*sources, cwd, options=()):
    """Link a program for a Cortex-M4 and run it on one that is emulated; what it prints."""
    library = Path(importlib.util.find_spec("ziglang").origin).parent / "lib" / "compiler_rt.zig"
    machine = "-target", "thumb-freestanding-eabi", "-mcpu=cortex_m4"
    zig("build-obj", *machine, "-OReleaseFast", "-femit-bin=rt.o", library, cwd=cwd)
    run(
        "arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=softfp",
        "-mfpu=fpv4-sp-d16", "-O2", "-nostartfiles", "-I.", HERE / "startup.c", *sources, "rt.o",
        *(f"-Wl,--defsym={name}={arm}" for name, arm in SOFT_FLOAT.items()),
        "--specs=rdimon.specs", "-T", HERE / "m4.ld", "-lm", "-Wl,-Map=run.map", "-o", "run.elf",
        cwd=cwd,
    )  # fmt: skip
    assert set(re.findall(r"libgcc\.a\((\w*df\w*)\.o\)", (cwd / "run.map").read_text())) <= COMPARES
    return run(
        "qemu-system-arm", "-M", "mps2-an386", "-cpu", "cortex-m4", "-semihosting", "-nographic",
        "-kernel", "run.elf", *options, cwd=cwd,
    )  # fmt: skip


A_TICK = 0.1 * 168e6
"""Cycles of an STM32F407 in a tick."""

ALL_EQUAL = "1000 of 1000 equal\n"
EXPORTED = "ssgikf", "learned-both", "covariance", "ssgikf-sceptical", "learned-sceptical"
NETWORKS = (0, "motion"), (8, "motion"), (0, "weighting"), (0, "both"), (8, "everything")
"""How many numbers each remembers, and the layers that it is."""


def exported(controller, target, folder):
    """Export a controller or a network; its vectors, some of which hold messages and payloads."""
    name = any_network(folder, *controller) if isinstance(controller, tuple) else controller
    scenario = find_scenario("es1", {"radio.frames": 5 if target == "x86-64" else 2})
    robot = ExportedRobot(find_layered_controller(name), scenario)
    export(robot, target, folder)
    vectors = np.fromfile(folder / "vectors.bin", robot.vector)
    assert vectors["n"].sum() > 10
    assert vectors["has_payload"].sum() > 10
    return vectors


@pytest.mark.parametrize("controller", [*EXPORTED, *NETWORKS])
@needs("gcc")
def test_a_robot_alone_commands_what_it_does_in_the_swarm(controller, tmp_path):
    vectors = exported(controller, "x86-64", tmp_path)
    run("gcc", "-O2", "-Wall", "-Werror", "example.c", "controller.o", "-o", "run", cwd=tmp_path)
    assert run("./run", cwd=tmp_path) == ALL_EQUAL
    vectors["wheels"][500, 0] += 1e-3
    vectors.tofile(tmp_path / "vectors.bin")
    assert run("./run", cwd=tmp_path, check=False) == "999 of 1000 equal\n"
    vectors[:3].tofile(tmp_path / "vectors.bin")
    with pytest.raises(subprocess.CalledProcessError) as short:
        run("./run", cwd=tmp_path)
    assert short.value.stdout.endswith(
        "ticks of 1000; export the controller again\n3 of 1000 equal\n"
    )
    (tmp_path / "vectors.bin").unlink()
    assert "vectors.bin: cannot be read" in run("./run", cwd=tmp_path, check=False)


def some(n, network):
    """So many of the exported controllers and a network; the others by `pytest -m slow`."""
    others = (pytest.param(each, marks=pytest.mark.slow) for each in EXPORTED[n:])
    return [*EXPORTED[:n], network, *others]


@pytest.mark.parametrize("controller", some(2, (8, "motion")))
@needs("arm-none-eabi-gcc", "qemu-system-arm")
def test_a_robot_alone_commands_the_same_on_its_chip(controller, tmp_path):
    exported(controller, "cortex-m4", tmp_path)
    assert run_on_cortex_m4("example.c", "controller.o", cwd=tmp_path) == ALL_EQUAL
    counting = "-icount", "shift=5"
    counted = run_on_cortex_m4(
        HERE / "instructions.c", "controller.o", cwd=tmp_path, options=counting
    )
    mean, most = map(int, counted.split())
    assert 1_000 < mean < most < 0.02 * A_TICK, "a tick takes a fiftieth of its time, at most"


@pytest.mark.parametrize("controller", some(1, (8, "everything")))
@needs("node")
def test_a_robot_alone_commands_the_same_in_web_assembly(controller, tmp_path):
    exported(controller, "wasm32", tmp_path)
    options = "-target", "wasm32-wasi", "-O2", "example.c", "controller.o", "-o", "run.wasm"
    zig("cc", *options, cwd=tmp_path)
    assert run("node", "--no-warnings", HERE / "wasi.mjs", cwd=tmp_path) == ALL_EQUAL


@pytest.mark.parametrize(
    ("name", "reason"),
    [("global", "it knows the ground truth"), ("boids-adaptive", "pair of robots")],
)
def test_what_cannot_run_on_a_robot_alone_is_refused(name, reason):
    with pytest.raises(ConfigError, match=f"'{name}' cannot be exported, because .*{reason}"):
        ExportedRobot(find_layered_controller(name), find_scenario("es1"))


def test_a_message_that_a_fault_changes_is_no_vector():
    stale = find_scenario("es1", {"faults.stale.share": 1.0})
    vectors = ExportedRobot(find_layered_controller("ssgikf"), stale).record_vectors(6, 6, 400)
    assert vectors["n"].sum() > 10
    assert not vectors["has_payload"].any()


ARGOS = """
#pragma once
#include <cstdio>
#include <string>
#include <sstream>
#include <vector>
#include <stdexcept>
#define THROW_ARGOSEXCEPTION(m) { std::ostringstream s; s << m; throw std::runtime_error(s.str()); }
#define REGISTER_CONTROLLER(kind, name) kind registered;
namespace argos {
typedef double Real; typedef unsigned char UInt8; typedef signed char SInt8;
typedef unsigned int UInt32; typedef signed int SInt32;
struct TConfigurationNode {};
template <class T> void GetNodeAttributeOrDefault(TConfigurationNode &, const std::string &, T &,
                                                  const T &) {}
struct CDegrees { explicit CDegrees(Real v) : v(v) {} Real GetValue() const { return v; } Real v; };
struct CRadians { Real GetValue() const { return v; } Real v; };
inline CDegrees ToDegrees(CRadians r) { return CDegrees(57.29577951308232 * r.v); }
inline CRadians ToRadians(CDegrees d) { return CRadians{d.v / 57.29577951308232}; }
struct CByteArray { UInt8 operator[](size_t k) const { return b[k]; } std::vector<UInt8> b; };
struct CCI_DifferentialSteeringActuator { void SetLinearVelocity(Real, Real) {} };
struct CCI_DifferentialSteeringSensor {
    struct SReading { Real CoveredDistanceLeftWheel, CoveredDistanceRightWheel; };
    const SReading &GetReading() const { return r; } SReading r; };
struct CCI_GroundSensor { const std::vector<Real> &GetReadings() const { return r; }
    std::vector<Real> r; };
struct CCI_ProximitySensor : CCI_GroundSensor {};
struct CCI_RangeAndBearingActuator { void SetData(size_t, UInt8) {} };
struct CCI_RangeAndBearingSensor {
    struct SPacket { Real Range; CRadians HorizontalBearing, VerticalBearing; CByteArray Data; };
    const std::vector<SPacket> &GetReadings() const { return r; } std::vector<SPacket> r; };
struct CCI_Controller {
    virtual ~CCI_Controller() {} virtual void Init(TConfigurationNode &) {} virtual void Reset() {}
    virtual void ControlStep() {} const std::string &GetId() const { return id; } std::string id;
    template <class T> T *GetActuator(const std::string &) { return nullptr; }
    template <class T> T *GetSensor(const std::string &) { return nullptr; } };
}
"""
"""What the controller calls of ARGoS, by the declarations of its control interface."""


PROBE = """
int main() {
    CSwarmForageController robot;
    CCI_RangeAndBearingSensor radio;
    robot.m_pcHear = &radio;
    for (UInt8 state : {UInt8(0), LISTENS, SPEAKS}) {
        std::vector<UInt8> heard, bytes(HEADER + CONTROLLER_PAYLOAD_SIZE, 1);
        bytes[2] = state, bytes[3] = 0; /* robot 1 has heard one other: robot 0 */
        radio.r = {{0.1, {}, {}, {bytes}}};
        controller_received_t received[CONTROLLER_SLOTS];
        printf("%d ", robot.Receive(received, heard));
    }
}
"""


@needs("g++")
def test_the_controller_for_argos_takes_in_what_is_spoken(tmp_path):
    exported("learned-both", "x86-64", tmp_path)
    robot = ExportedRobot(find_layered_controller("learned-both"), find_scenario("es1"))
    write_argos(robot, tmp_path)
    source = (tmp_path / "argos_controller.cpp").read_text()
    for header in re.findall(r"<(argos3/\S+)>", source):
        (tmp_path / header).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / header).write_text(ARGOS)
    (tmp_path / "probe.cpp").write_text(source.replace("private:", "public:") + PROBE)
    flags = "-std=c++17", "-Wall", "-Werror", "-I."
    run("g++", *flags, "probe.cpp", "controller.o", "-o", "probe", cwd=tmp_path)
    assert run("./probe", cwd=tmp_path) == "0 0 1 "


def test_the_readme_names_every_other_file(command):
    options = "--target=x86-64", "--argos", "--set=radio.slots=5", "--out=robot"
    assert command("export", "ssgiff:beta=0.02", *options)[0] == 0
    header = Path("robot/controller.h").read_text()
    assert header.startswith("/* ssgiff:beta=0.02 in es1, radio.slots=5: the controller")
    named = re.findall(r"^\| `(.+?)` \|", Path("robot/README.md").read_text(), re.MULTILINE)
    assert {"README.md", *named} == {each.name for each in Path("robot").iterdir()}


def test_an_experiment_of_argos_has_the_arena_of_the_scenario(tmp_path):
    scenario = find_scenario("mg1-hexagon")
    robot = ExportedRobot(find_layered_controller("ssgikf"), scenario)
    write_argos(robot, tmp_path, seed=3)
    root = ElementTree.parse(tmp_path / "experiment.argos").getroot()
    robots = root.findall("arena/e-puck/body")
    poses = robot.loop(3).world.robots["pose"][0]
    written = [[float(x) for x in each.get("position").split(",")[:2]] for each in robots]
    assert np.allclose(written, poses[:, :2], atol=1e-5)
    assert len(root.findall("arena/box")) == 4 + len(scenario.arena.corners) + len(
        scenario.obstacles
    )
    assert root.find("framework/experiment").get("ticks_per_second") == "10"
    levels = [root.find(f".//{each}").get("noise_level") for each in ("proximity", "ground")]
    assert levels == ["0.00586577", "0.15"]
    assert root.find("media/range_and_bearing").get("check_occlusions") == "false"
    light = floor(scenario)
    per_metre = light.shape[1] / (scenario.arena.length + 1.0)
    for area, brightness in zip(scenario.places, (0, 128), strict=False):
        column = round(light.shape[1] / 2 + per_metre * area.centre[0])
        row = round(light.shape[0] / 2 - per_metre * area.centre[1])
        assert light[row, column] == brightness


def test_a_swarm_that_a_chip_has_no_room_for_is_refused(tmp_path):
    scenario = find_scenario("es3", {"task.n_robots": 250, "task.start_radius": 1.0})
    large = ExportedRobot(find_layered_controller("ssgikf"), scenario)
    with pytest.raises(ConfigError, match=r"needs \d+ bytes of ram .* STM32F407 has 196608"):
        export(large, "cortex-m4", tmp_path)
    assert not list(tmp_path.iterdir())


def test_only_one_world_of_a_compiled_loop_goes_elsewhere():
    scenario = find_scenario("es1")
    for seeds, physics in (([0, 1], "kinematic"), ([0], "rigid")):
        with pytest.raises(ConfigError, match="one world under physics='kinematic'"):
            memory_of(Loop(scenario, find_controller("nc"), seeds, physics))
