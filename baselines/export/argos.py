"""A scenario and a controller for ARGoS 3: an experiment, its floor, and C++ that links the code.

What is written follows the examples and sources of ARGoS (github.com/ilpincy/argos3-examples,
epuck_obstacleavoidance.argos; github.com/ilpincy/argos3, epuck_entity.cpp, whose robot has the
radius, axle and ground sensors of ours). It was not run in ARGoS.
"""

import math
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from string import Template
from xml.etree import ElementTree as Xml

import numpy as np

from baselines.export.robot import ExportedRobot
from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.equations.ground import WHITE, brightness
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.areas import KINDS
from swarm_forage_env.foraging.scenario import Scenario

Point = Sequence[float]

WALL = 0.02
"""Thickness of the arena's walls [m], outside of it."""
HEIGHT = 0.2
"""Height of walls and obstacles [m]."""
MOST_ROBOTS = 256
"""The number of a robot is a byte of its messages."""
A_METRE = 400
"""Pixels of the floor."""


def write_argos(exported: ExportedRobot, folder: Path, seed: int = 0) -> None:
    """Write `experiment.argos`, `floor.png` and `argos_controller.cpp` beside the machine code.

    Robots start where they do in the simulated world of that seed.
    """
    from matplotlib.image import imsave

    scenario = exported.scenario
    if exported.n_robots > MOST_ROBOTS:
        raise ConfigError(
            f"{exported.n_robots} robots: a message for ARGoS has room for numbers below"
            f" {MOST_ROBOTS}; take fewer: --set task.n_robots=50"
        )
    root = experiment(exported, seed)
    Xml.indent(root)
    text = Xml.tostring(root, xml_declaration=True, encoding="utf-8")
    write_atomically(folder / "experiment.argos", text + b"\n")
    imsave(folder / "floor.png", floor(scenario), cmap="grey", vmin=0, vmax=255)
    source = (files("baselines.export") / "templates" / "argos_controller.cpp").read_text("utf-8")
    words = {
        "name": exported.name,
        "version": version("swarm-forage"),
        "axle": f"{scenario.robot.axle:g}",
    }
    text = Template(source).substitute(words).encode()
    write_atomically(folder / "argos_controller.cpp", text)


def experiment(exported: ExportedRobot, seed: int) -> Xml.Element:
    """The experiment: time, controller, sensors with their noise, arena, robots and radio."""
    scenario = exported.scenario
    root = Xml.Element("argos-configuration")
    framework = Xml.SubElement(root, "framework")
    _add(framework, "system", threads=0)
    ticks = round(1.0 / scenario.tick)
    _add(framework, "experiment", length=scenario.task.duration, ticks_per_second=ticks,
         random_seed=seed + 1)  # fmt: skip
    _add_controller(Xml.SubElement(root, "controllers"), scenario, seed)
    size = scenario.arena.length + 1.0, scenario.arena.width + 1.0, 1.0
    arena = _add(root, "arena", size=_numbers(size), center="0,0,0.5")
    _add(arena, "floor", id="floor", source="image", path="floor.png")
    for k, wall in enumerate(_walls(scenario)):
        _add_wall(arena, f"wall_{k}", *wall)
    for k, each in enumerate(scenario.obstacles):
        if len(each.points) == 1:
            shape = {"id": f"disc_{k}", "radius": each.radius, "height": HEIGHT}
            disc = _add(arena, "cylinder", **shape, movable="false")
            _add(disc, "body", position=_numbers((*each.points[0], 0.0)), orientation="0,0,0")
    bytes_told = 2 + 2 * scenario.radio.slots + exported.message_dtype.itemsize
    world = exported.loop(seed).world
    for k, (x, y, heading) in enumerate(world.robots["pose"][0]):
        robot = _add(arena, "e-puck", id=f"epuck_{k}", rab_range=scenario.radio.max_range,
                     rab_data_size=bytes_told)  # fmt: skip
        turn = math.degrees(heading)
        _add(robot, "body", position=_numbers((x, y, 0.0)), orientation=_numbers((turn, 0, 0)))
        _add(robot, "controller", config="swarm_forage")
    _add(Xml.SubElement(root, "physics_engines"), "dynamics2d", id="dyn2d")
    _add(Xml.SubElement(root, "media"), "range_and_bearing", id="rab")
    _add(Xml.SubElement(root, "visualization"), "qt-opengl")  # codespell:ignore visualization
    return root


def floor(scenario: Scenario) -> UInt8[Array, "rows columns"]:
    """The brightness of the floor as ARGoS's image has it, seen from above: y upwards."""
    half_x, half_y = 0.5 * scenario.arena.length + 0.5, 0.5 * scenario.arena.width + 0.5
    x = np.linspace(-half_x, half_x, round(2 * half_x * A_METRE))
    y = np.linspace(half_y, -half_y, round(2 * half_y * A_METRE))[:, None]
    light = np.full((len(y), len(x)), WHITE)
    for area in reversed(scenario.places):
        is_within = np.hypot(x - area.centre[0], y - area.centre[1]) <= scenario.task.area_radius
        light[is_within] = brightness(KINDS.index(area.kind))
    return np.rint(255.0 * light).astype(np.uint8)


def _add_controller(parent: Xml.Element, scenario: Scenario, seed: int) -> None:
    sensors, radio = scenario.sensors, scenario.radio
    error = 100.0 * sensors.wheel_noise * scenario.robot.cruise_speed * scenario.tick  # [cm]
    library = "build/libargos_controller.so"
    own = _add(parent, "swarm_forage", id="swarm_forage", library=library)
    told = Xml.SubElement(own, "actuators")
    _add(told, "differential_steering", implementation="default")
    _add(told, "range_and_bearing", implementation="default")
    sensed = Xml.SubElement(own, "sensors")
    _add(sensed, "differential_steering", implementation="default",
         dist_noise_range=f"{-error:.6g}:{error:.6g}")  # fmt: skip
    _add(sensed, "proximity", implementation="default", noise_level=sensors.proximity_noise)
    _add(sensed, "ground", implementation="rot_z_only", noise_level=sensors.ground_noise)
    lost = 0.5 * (radio.loss_near + radio.loss_far)
    _add(sensed, "range_and_bearing", implementation="medium", medium="rab",
         noise_std_dev=radio.range_noise / math.sqrt(3.0), packet_drop_prob=lost)  # fmt: skip
    _add(own, "params", seed=seed)


def _walls(scenario: Scenario) -> Iterator[tuple[Point, Point, float]]:
    """Both ends of each wall, and half its thickness [m]."""
    x, y = 0.5 * (scenario.arena.length + WALL), 0.5 * (scenario.arena.width + WALL)
    outline = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
    yield from ((a, b, 0.5 * WALL) for a, b in pairwise(outline))
    corners = list(scenario.arena.corners)
    yield from ((a, b, 0.5 * WALL) for a, b in pairwise([*corners, *corners[:1]]))
    for each in scenario.obstacles:
        points = [*each.points, *(each.points[:1] if each.is_closed else ())]
        yield from ((a, b, each.radius) for a, b in pairwise(points))


def _add_wall(arena: Xml.Element, name: str, a: Point, b: Point, half: float) -> None:
    along, across = b[0] - a[0], b[1] - a[1]
    size = math.hypot(along, across) + 2.0 * half, 2.0 * half, HEIGHT
    wall = _add(arena, "box", id=name, size=_numbers(size), movable="false")
    middle = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.0
    turn = math.degrees(math.atan2(across, along))
    _add(wall, "body", position=_numbers(middle), orientation=_numbers((turn, 0.0, 0.0)))


def _add(parent: Xml.Element, tag: str, **attributes: object) -> Xml.Element:
    """A new element; numbers in six digits."""
    told = {
        name: f"{value:.6g}" if isinstance(value, float) else str(value)
        for name, value in attributes.items()
    }
    return Xml.SubElement(parent, tag, told)


def _numbers(values: Sequence[float]) -> str:
    return ",".join(f"{value:.6g}" for value in values)
