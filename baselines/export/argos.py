"""Export of a scenario and a controller to ARGoS 3: experiment, floor, and a controller in C++.

The files follow the examples and sources of ARGoS (github.com/ilpincy/argos3-examples,
epuck_obstacleavoidance.argos; github.com/ilpincy/argos3, epuck_entity.cpp, whose robot has the
same radius, axle and ground sensors). They have not been run in ARGoS.
"""

import math
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path

import numpy as np

from baselines.export.files import filled
from baselines.export.robot import ExportedRobot
from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.equations.ground import GREY, WHITE, brightness
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.scenario import Scenario

Point = Sequence[float]

WALL = 0.02  # thickness of the walls [m], outside the arena
HEIGHT = 0.2  # height of walls and obstacles [m]
MAX_ROBOTS = 256  # messages hold the index of the robot as one byte
PIXELS_PER_METRE = 400  # pixels of the floor image per metre

INFRARED = 1.08212 / 36.8961
"""Error of the distance at contact for all of an infrared reading [m]: `response` by its slope."""


def check_for_argos(exported: ExportedRobot) -> None:
    """ConfigError for more robots than messages can name, and for what ARGoS cannot have."""
    scenario = exported.scenario
    if exported.n_robots > MAX_ROBOTS:
        raise ConfigError(
            f"{exported.n_robots} robots: a message for ARGoS has room for robot numbers below"
            f" {MAX_ROBOTS}; use fewer robots: --set task.n_robots=50"
        )
    for feature, is_present in {
        "faulty robots": scenario.faults.is_any,
        "an area that moves": any(each.moves_at is not None for each in scenario.places),
        "a tick that no second is a multiple of": not math.isclose(
            scenario.tick * round(1.0 / scenario.tick), 1.0
        ),
    }.items():
        if is_present:
            raise ConfigError(
                f"--argos: scenario '{scenario.name}' has {feature}, which an ARGoS experiment"
                " cannot have; use a scenario without, such as es1"
            )


def write_argos(exported: ExportedRobot, folder: Path, seed: int = 0) -> None:
    """Write `experiment.argos`, `floor.png` and `argos_controller.cpp` to the folder of the export.

    Robots start at the poses of the simulated world with this seed.
    """
    from matplotlib.image import imsave

    scenario = exported.scenario
    imsave(folder / "floor.png", floor(scenario), cmap="grey", vmin=0, vmax=255)
    write_atomically(folder / "experiment.argos", experiment(exported, seed).encode())
    axle = f"{scenario.robot.axle:g}"
    words = {"name": exported.names[0], "version": version("swarm-forage"), "axle": axle}
    controller = filled("argos_controller.cpp", words)
    write_atomically(folder / "argos_controller.cpp", controller.encode())


def experiment(exported: ExportedRobot, seed: int) -> str:
    """Return the experiment as XML: time, controller, sensors with noise, arena, robots, radio."""
    scenario, bodies = exported.scenario, "".join(_bodies(exported, seed))
    sensors, radio = scenario.sensors, scenario.radio
    numbers = {
        "duration": scenario.task.duration,
        "ticks": round(1.0 / scenario.tick),
        "random_seed": seed + 1,
        "seed": seed,
        "error": 100.0 * sensors.wheel_noise * scenario.robot.cruise_speed * scenario.tick,  # [cm]
        "proximity_noise": sensors.proximity_noise * INFRARED,
        "ground_noise": sensors.ground_noise * GREY,
        "range_noise": radio.range_noise / math.sqrt(3.0),
        "lost": 0.5 * (radio.loss_near + radio.loss_far),
    }
    size = _numbers((scenario.arena.length + 1.0, scenario.arena.width + 1.0, 1.0))
    words = {name: _numbers((each,)) for name, each in numbers.items()}
    words["is_shadowed"] = str(radio.is_shadowed).lower()
    return filled("experiment.argos", {**words, "size": size, "bodies": bodies})


def _bodies(exported: ExportedRobot, seed: int) -> Iterator[str]:
    """Yield the elements of walls, discs and robots."""
    scenario = exported.scenario
    for k, (a, b, half) in enumerate(_walls(scenario)):
        along, across = b[0] - a[0], b[1] - a[1]
        size = _numbers((math.hypot(along, across) + 2.0 * half, 2.0 * half, HEIGHT))
        middle = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
        head = f'box id="wall_{k}" size="{size}" movable="false"'
        yield _body(head, middle, math.atan2(across, along))
    for k, each in enumerate(scenario.obstacles):
        if len(each.points) == 1:
            size = f'radius="{each.radius:.6g}" height="{HEIGHT:g}"'
            yield _body(f'cylinder id="disc_{k}" {size} movable="false"', each.points[0], 0.0)
    radio = f'rab_range="{scenario.radio.max_range:.6g}"'
    radio += f' rab_data_size="{3 + 2 * scenario.radio.slots + exported.message_dtype.itemsize}"'
    for k, (x, y, heading) in enumerate(exported.loop(seed).world.robots["pose"][0]):
        own = '  <controller config="swarm_forage" />'
        yield _body(f'e-puck id="epuck_{k}" {radio}', (x, y), heading, own)


def _body(head: str, place: Point, turn: float, *more: str) -> str:
    """Return an element at a place [m], rotated by an angle [rad]."""
    at = f'position="{_numbers((*place, 0.0))}" orientation="{math.degrees(turn):.6g},0,0"'
    lines = f"<{head}>", f"  <body {at} />", *more, f"</{head.partition(' ')[0]}>"
    return "".join(f"    {line}\n" for line in lines)


def floor(scenario: Scenario) -> UInt8[Array, "rows columns"]:
    """Return the image of the floor for ARGoS: brightness, seen from above, y upwards."""
    half_x, half_y = 0.5 * scenario.arena.length + 0.5, 0.5 * scenario.arena.width + 0.5
    x = np.linspace(-half_x, half_x, round(2 * half_x * PIXELS_PER_METRE))
    y = np.linspace(half_y, -half_y, round(2 * half_y * PIXELS_PER_METRE))[:, None]
    light = np.full((len(y), len(x)), WHITE)
    for area in reversed(scenario.places):
        is_within = np.hypot(x - area.centre[0], y - area.centre[1]) <= scenario.task.area_radius
        light[is_within] = brightness(AREAS.index(area.kind))
    return np.rint(255.0 * light).astype(np.uint8)


def _walls(scenario: Scenario) -> Iterator[tuple[Point, Point, float]]:
    """Yield both ends of each wall, and half its thickness [m]."""
    x, y = 0.5 * (scenario.arena.length + WALL), 0.5 * (scenario.arena.width + WALL)
    outline = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
    yield from ((a, b, 0.5 * WALL) for a, b in pairwise(outline))
    corners = list(scenario.arena.corners)
    yield from ((a, b, 0.5 * WALL) for a, b in pairwise([*corners, *corners[:1]]))
    for each in scenario.obstacles:
        points = [*each.points, *(each.points[:1] if each.is_closed else ())]
        yield from ((a, b, each.radius) for a, b in pairwise(points))


def _numbers(values: Sequence[float]) -> str:
    return ",".join(f"{value:.6g}" for value in values)
