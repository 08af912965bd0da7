"""Subsumption motion: talk, avoid, forage, wander, in this order."""

import math

import numpy as np
import pytest

from baselines.motion.subsumption import KEEP_RIGHT, SubsumptionParameters, obstacle, way_round
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.differential_drive import wheels_towards
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.scenarios import find_scenario
from tests.outside import OutsideMotion

SECTOR = math.radians(100.0)
FRONT_RIGHT, RIGHT, BACK, LEFT, FRONT_LEFT = 0, 2, 3, 5, 7


@pytest.mark.parametrize(
    ("angle", "creep", "wheels"),
    [
        (0.0, 0.0, (1.0, 1.0)),
        (math.pi / 2, 0.0, (-1.0, 1.0)),
        (-math.pi / 2, 0.0, (1.0, -1.0)),
        (math.pi, 0.0, (-1.0, 1.0)),
        (0.25, 0.0, ((math.cos(0.25) - 0.5) / (math.cos(0.25) + 0.5), 1.0)),
        (math.pi / 2, 0.15, (-0.85 / 1.15, 1.0)),
    ],
)
def test_wheels_worked_by_hand(angle, creep, wheels):
    assert wheels_towards(angle, creep) == pytest.approx(wheels)


def seen(readings):
    """Proximity, by sensor."""
    return np.array([readings.get(sensor, 0.0) for sensor in range(8)], np.float32)


@pytest.mark.parametrize(
    ("readings", "bearing_deg"),
    [
        ({FRONT_LEFT: 0.5, FRONT_RIGHT: 0.5}, 0.0), ({LEFT: 0.9}, 90.0), ({RIGHT: 0.9}, -90.0),
        ({FRONT_RIGHT: 0.4}, -17.0), ({LEFT: 0.5, RIGHT: 0.5, FRONT_LEFT: 0.1}, 17.0),
        ({FRONT_LEFT: 0.5, BACK: 1.0}, 17.0),
    ],
)  # fmt: skip
def test_the_bearing_of_an_obstacle_is_that_of_the_vector_sum(readings, bearing_deg):
    found = obstacle(seen(readings), 0.05, SECTOR)
    assert found == pytest.approx((True, math.radians(bearing_deg)), abs=1e-6)


@pytest.mark.parametrize("readings", [{}, {BACK: 1.0}, {FRONT_LEFT: 0.05}])
def test_what_is_weak_or_behind_is_no_obstacle(readings):
    assert obstacle(seen(readings), 0.06, SECTOR) == (False, 0.0)


@pytest.mark.parametrize(
    ("bearing", "course"), [(0.0, -100.0), (20.0, -80.0), (90.0, -10.0), (-29.0, -129.0),
                            (-31.0, 69.0), (-90.0, 10.0)]
)  # fmt: skip
def test_the_way_round_keeps_right_unless_the_obstacle_is_there(bearing, course):
    swerve = math.radians(100.0)
    assert math.degrees(way_round(math.radians(bearing), swerve, KEEP_RIGHT)) == pytest.approx(
        course
    )


def test_the_literal_rule_turns_opposite_to_the_obstacle():
    # TR 5.1
    scenario, part = find_scenario("es1", {"n_robots": 1}), SubsumptionParameters
    motion = OutsideMotion(part(gap=0.04, avoidance="literal").layer(scenario), scenario, [0])
    situation, readings = (kind.array((1,)).view(np.recarray) for kind in (Situation, Readings))
    situation.goal[:], readings.proximity[:] = np.eye(3)[-1], seen({FRONT_LEFT: 0.5})
    heard, wheels = Heard.array((1,), slots=4), np.zeros((1, 2), np.float32)
    opposite = wheels_towards(math.radians(17.0 - 180.0), 0.15)
    np.testing.assert_allclose(motion(situation, readings, heard, wheels), [opposite], rtol=1e-6)
