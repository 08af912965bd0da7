"""What an observation holds: a table of each part of the interface, with units and bounds."""

import math

import numpy as np

from swarm_forage_env.envs.bounds import Bounds
from swarm_forage_env.envs.layout import GOALS, Field, Slot, field
from swarm_forage_env.interface import WORDS
from swarm_forage_env.scenario import Scenario

FLAG, SHARE, ANGLE = (0.0, 1.0), (0.0, 1.0), (-math.pi, math.pi)
SPEED = (-1.0, 1.0)
AREAS = ("nest", "prey")
WHEELS = ("left", "right")

GOAL = field("goal", GOALS, "0 or 1", FLAG, shape=(), dtype=np.int8)


def encounter_fields(bounds: Bounds) -> tuple[Field, ...]:
    """The exchange that just ended, as `Encounter` says; zeros where none did."""
    path, apart = (0.0, bounds.path), (0.0, 2.0 * bounds.believed)
    away = (0.0, bounds.believed)
    return (
        field("valid", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        field("own_p", AREAS, "m", path),
        field("heard_p", AREAS, "m", path),
        field("own_known", AREAS, "0 or 1", FLAG, dtype=np.bool_),
        field("heard_known", AREAS, "0 or 1", FLAG, dtype=np.bool_),
        field("disagreement", AREAS, "m", apart),
        field("own_distance", AREAS, "m", away),
        field("heard_distance", AREAS, "m", away),
        field("range", ("",), "m", (0.0, bounds.beam), range_noise(bounds.scenario), ()),
        field("frames", ("",), "frames", (0.0, bounds.frames), shape=()),
        GOAL,
    )


def situation_fields(bounds: Bounds, slots: int) -> tuple[Field, ...]:
    """What the motion layer sees, as `Situation` says."""
    place = (-bounds.believed, bounds.believed)
    corners = [f"{area}.{axis}" for area in AREAS for axis in "xy"]
    return (
        *sensor_fields(bounds),
        field("target", "xy", "m", place),
        field("areas", corners, "m", place, shape=(2, 2)),
        field("p", AREAS, "m", (0.0, bounds.path)),
        field("known", AREAS, "0 or 1", FLAG, dtype=np.bool_),
        GOAL,
        field("talking", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        field("heard", map(str, range(slots)), "0 or 1", FLAG, dtype=np.bool_),
        beam_field(bounds, slots),
        field("wheels", WHEELS, "of cruise speed", SPEED),
    )


def readings_fields(bounds: Bounds) -> tuple[Field, ...]:
    """What the robot's own sensors say, as `Readings` says."""
    sensors, robot = bounds.scenario.sensors, bounds.scenario.robot
    error = sensors.wheel_noise * robot.cruise_speed * bounds.scenario.tick
    turned = f"+- {2.0 * error / robot.axle:.3g} rad"
    slots = (
        Slot("odometry.distance", "m", -bounds.step, bounds.step, f"+- {error:.3g} m"),
        Slot("odometry.turn", "rad", -bounds.turn, bounds.turn, turned),
    )
    return (*sensor_fields(bounds), Field("odometry", (2,), np.float32, slots))


def heard_fields(bounds: Bounds, slots: int) -> tuple[Field, ...]:
    """The messages of the last tick, as `Heard` says, but for the sender's number."""
    told = [f"{slot}.{word}" for slot in range(slots) for word in range(WORDS)]
    most = (0.0, float(bounds.scenario.radio.frames))
    return (
        field("valid", map(str, range(slots)), "0 or 1", FLAG, dtype=np.bool_),
        beam_field(bounds, slots),
        field("frames", map(str, range(slots)), "frames", most, dtype=np.int32),
        field("words", told, "as sent", SPEED, shape=(slots, WORDS)),
    )


def sensor_fields(bounds: Bounds) -> tuple[Field, Field]:
    """Proximity and ground, which both the motion layer and a learner of everything see."""
    sensors = bounds.scenario.sensors
    light, dark = (0.0, bounds.brightness), f"x (1 +- {sensors.ground_noise:g})"
    near = f"x (1 +- {sensors.proximity_noise:g})"
    return (
        field("proximity", map(str, range(8)), "reading", SHARE, near),
        field("ground", ("left", "middle", "right"), "brightness", light, dark),
    )


def beam_field(bounds: Bounds, n_slots: int) -> Field:
    """Range, bearing, and bearing back of the sender in each message slot."""
    far, noise = bounds.beam, range_noise(bounds.scenario)
    error = f"+- {bounds.scenario.radio.bearing_noise:.3g} rad, each frame"
    slots: list[Slot] = []
    for k in range(n_slots):
        slots += (
            Slot(f"beam.{k}.range", "m", 0.0, far, noise),
            Slot(f"beam.{k}.bearing", "rad", *ANGLE, error),
            Slot(f"beam.{k}.bearing_back", "rad", *ANGLE, error),
        )
    return Field("beam", (n_slots, 3), np.float32, tuple(slots))


def range_noise(scenario: Scenario) -> str:
    """How badly one frame measures the range, in words."""
    if scenario.radio.is_board:
        return "lognormal, as the real board, each frame"
    return f"+- {scenario.radio.range_noise:g} m, each frame"
