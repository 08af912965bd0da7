"""Observations of robots that visit waypoints: a table of each part, with units and bounds."""

import math

import numpy as np

from swarm_forage_env.spaces import Feature, FeatureGroup, feature_group
from swarm_forage_env.waypoints.scenario import WaypointsScenario

WORDS = 12
"""Numbers in a message of a learner of everything."""

UNIT, FLAG, PULL = (0.0, 1.0), (0.0, 1.0), (-1.0, 1.0)
ANGLE = (-math.pi, math.pi)
ANYWHERE, ANY_SIZE = (-math.inf, math.inf), (0.0, math.inf)

PLACE_SCALE, VARIANCE_SCALE, SPEED_SCALE, TURN_SCALE = 2.0, 0.1, 0.25, 0.5
"""Typical sizes: of the way to a place [m], of the norm of a covariance [m^2], of a speed [m/s], of
a turn rate [rad/s]."""


def correction_features() -> tuple[FeatureGroup, ...]:
    """The correction that is about to be made, as `WeightingInput` says."""
    return (
        feature_group("valid", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        feature_group("neighbours", ("",), "of all robots", UNIT, shape=()),
        feature_group("own_doubt", ("",), "m^2", ANY_SIZE, shape=(), scale=VARIANCE_SCALE),
        feature_group("heard_doubt", ("",), "m^2", ANY_SIZE, shape=(), scale=VARIANCE_SCALE),
        feature_group("disagreement", ("",), "m", ANY_SIZE, shape=(), scale=PLACE_SCALE),
    )


def flock_features() -> tuple[FeatureGroup, ...]:
    """What the motion layer sees, as `MotionInput` says."""
    ways = (
        *((name, "m", PLACE_SCALE) for name in ("goal", "home", "centre")),
        *((name, "", 1.0) for name in ("crowd", "flow")),
        ("velocity", "m/s", SPEED_SCALE),
    )
    vectors = [feature_group(name, "xy", unit, ANYWHERE, scale=scale) for name, unit, scale in ways]
    shares = [
        feature_group(name, ("",), "share", ANY_SIZE, shape=(), scale=1.0)
        for name in ("doubt", "drift")
    ]
    return (
        *vectors,
        feature_group("density", ("",), "of all robots", UNIT, shape=()),
        *shares,
        feature_group("arrived", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        feature_group("pull", "xy", "of the highest acceleration", PULL),
    )


def reading_features(scenario: WaypointsScenario) -> tuple[FeatureGroup, ...]:
    """What the robot's own sensors say, as `Readings` says."""
    sensors = scenario.sensors
    motion = (
        Feature(
            "motion.speed", "m/s", *ANYWHERE, f"sd {sensors.speed_noise:g} m/s and a bias",
            SPEED_SCALE,
        ),
        Feature(
            "motion.turn", "rad/s", *ANYWHERE, f"sd {sensors.turn_noise:g} rad/s and a bias",
            TURN_SCALE,
        ),
    )  # fmt: skip
    fix = f"sd {sensors.home_noise:g}"
    return (
        FeatureGroup("motion", (2,), np.float32, motion),
        feature_group("compass", ("",), "rad", ANGLE, shape=()),
        feature_group("at_home", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        feature_group("fix", ("x", "y", "heading"), "m, rad", ANYWHERE, fix, scale=PLACE_SCALE),
        feature_group("goal", "xy", "m", ANYWHERE, scale=PLACE_SCALE),
    )


def sighting_features(scenario: WaypointsScenario) -> tuple[FeatureGroup, ...]:
    """Who is seen, as `Sighting` says, and what they said."""
    sensors, others = scenario.sensors, [str(k) for k in range(scenario.task.n_robots)]
    told = [f"{other}.{word}" for other in others for word in range(WORDS)]
    return (
        feature_group("seen", others, "0 or 1", FLAG, dtype=np.bool_),
        feature_group("range", others, "m", (0.0, sensors.reach), f"sd {sensors.range_noise:g} m"),
        feature_group("bearing", others, "rad", ANGLE, f"sd {sensors.bearing_noise:g} rad"),
        feature_group("words", told, "as sent", PULL, shape=(len(others), WORDS)),
    )
