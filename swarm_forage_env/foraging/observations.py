"""Observations of robots that forage: a table of each part, with units and bounds."""

import math

import numpy as np

from swarm_forage_env.foraging.limits import max_brightness, max_step, max_turn
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.spaces import GOALS, Feature, FeatureGroup, feature_group

WORDS = 12
"""Numbers in a message of a learner of everything."""

FLAG, SHARE, ANGLE = (0.0, 1.0), (0.0, 1.0), (-math.pi, math.pi)
SPEED = (-1.0, 1.0)
ANYWHERE, FAR = (-math.inf, math.inf), (0.0, math.inf)

PLACE_SCALE, PATH_SCALE, APART_SCALE, BEAM_SCALE, FRAMES_SCALE = 1.0, 2.0, 0.5, 0.1, 8.0
"""Typical sizes: of the way to an area [m], of p [m], of the distance between two estimates of one
place [m], of the range of a sender [m], of the frames averaged in an exchange. The same in all
scenarios, so that a policy can go from one to another."""

AREAS = ("nest", "prey")
WHEELS = ("left", "right")

GOAL = feature_group("goal", GOALS, "0 or 1", FLAG, shape=(), dtype=np.int8)


def encounter_features(scenario: Scenario) -> tuple[FeatureGroup, ...]:
    """The exchange that just ended, as `WeightingInput` says; zeros where none did."""
    return (
        feature_group("valid", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        feature_group("own_p", AREAS, "m", FAR, scale=PATH_SCALE),
        feature_group("heard_p", AREAS, "m", FAR, scale=PATH_SCALE),
        feature_group("own_known", AREAS, "0 or 1", FLAG, dtype=np.bool_),
        feature_group("heard_known", AREAS, "0 or 1", FLAG, dtype=np.bool_),
        feature_group("disagreement", AREAS, "m", FAR, scale=APART_SCALE),
        feature_group("own_distance", AREAS, "m", FAR, scale=PLACE_SCALE),
        feature_group("heard_distance", AREAS, "m", FAR, scale=PLACE_SCALE),
        feature_group(
            "range", ("",), "m", FAR, range_noise(scenario), (),
            scale=BEAM_SCALE,
        ),
        feature_group("frames", ("",), "frames", FAR, shape=(), scale=FRAMES_SCALE),
        GOAL,
    )  # fmt: skip


def situation_features(scenario: Scenario, slots: int) -> tuple[FeatureGroup, ...]:
    """What the motion layer sees, as `MotionInput` says."""
    corners = [f"{area}.{axis}" for area in AREAS for axis in "xy"]
    return (
        *sensor_features(scenario),
        feature_group("target", "xy", "m", ANYWHERE, scale=PLACE_SCALE),
        feature_group("areas", corners, "m", ANYWHERE, shape=(2, 2), scale=PLACE_SCALE),
        feature_group("p", AREAS, "m", FAR, scale=PATH_SCALE),
        feature_group("known", AREAS, "0 or 1", FLAG, dtype=np.bool_),
        GOAL,
        feature_group("talking", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        feature_group("heard", map(str, range(slots)), "0 or 1", FLAG, dtype=np.bool_),
        beam_features(scenario, slots),
        feature_group("wheels", WHEELS, "of cruise speed", SPEED),
    )


def reading_features(scenario: Scenario) -> tuple[FeatureGroup, ...]:
    """What the robot's own sensors say, as `Readings` says."""
    sensors, robot = scenario.sensors, scenario.robot
    error = sensors.wheel_noise * robot.cruise_speed * scenario.tick
    turned = f"+- {2.0 * error / robot.axle:.3g} rad"
    step, turn = max_step(scenario), max_turn(scenario)
    slots = (
        Feature("odometry.distance", "m", -step, step, f"+- {error:.3g} m"),
        Feature("odometry.turn", "rad", -turn, turn, turned),
    )
    return (*sensor_features(scenario), FeatureGroup("odometry", (2,), np.float32, slots))


def heard_features(scenario: Scenario, slots: int) -> tuple[FeatureGroup, ...]:
    """The messages of the last tick, as `Heard` says, but for the sender's number."""
    told = [f"{slot}.{word}" for slot in range(slots) for word in range(WORDS)]
    most = (0.0, float(scenario.radio.frames))
    return (
        feature_group("valid", map(str, range(slots)), "0 or 1", FLAG, dtype=np.bool_),
        beam_features(scenario, slots),
        feature_group("frames", map(str, range(slots)), "frames", most, dtype=np.int32),
        feature_group("words", told, "as sent", SPEED, shape=(slots, WORDS)),
    )


def sensor_features(scenario: Scenario) -> tuple[FeatureGroup, FeatureGroup]:
    """Proximity and ground, which both the motion layer and a learner of everything see."""
    sensors = scenario.sensors
    light, dark = (0.0, max_brightness(scenario)), f"x (1 +- {sensors.ground_noise:g})"
    near = f"x (1 +- {sensors.proximity_noise:g})"
    return (
        feature_group("proximity", map(str, range(8)), "reading", SHARE, near),
        feature_group("ground", ("left", "middle", "right"), "brightness", light, dark),
    )


def beam_features(scenario: Scenario, n_slots: int) -> FeatureGroup:
    """Range, bearing, and bearing back of the sender in each message slot."""
    noise = range_noise(scenario)
    error = f"+- {scenario.radio.bearing_noise:.3g} rad, each frame"
    slots: list[Feature] = []
    for k in range(n_slots):
        slots += (
            Feature(f"beam.{k}.range", "m", *FAR, noise, BEAM_SCALE),
            Feature(f"beam.{k}.bearing", "rad", *ANGLE, error),
            Feature(f"beam.{k}.bearing_back", "rad", *ANGLE, error),
        )
    return FeatureGroup("beam", (n_slots, 3), np.float32, tuple(slots))


def range_noise(scenario: Scenario) -> str:
    """How badly one frame measures the range, in words."""
    if scenario.radio.is_board:
        return "lognormal, as the real board, each frame"
    return f"+- {scenario.radio.range_noise:g} m, each frame"
