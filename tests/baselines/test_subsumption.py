"""Subsumption motion: talk, avoid, forage, wander, in this order."""

import math

import numpy as np
import pytest
from scipy import stats

from baselines.motion.subsumption import (
    KEEP_RIGHT,
    SubsumptionParameters,
    obstacle,
    steer,
    way_round,
)
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.differential_drive import wheels_towards
from swarm_forage_env.equations.random_draws import GOLDEN, symmetric
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.random_streams import streams
from swarm_forage_env.scenarios import find_scenario

SECTOR = math.radians(100.0)
FRONT_RIGHT, RIGHT, BACK, LEFT, FRONT_LEFT = 0, 2, 3, 5, 7


@entry_point
def steer_all(situations, readings, heard, wheels, courses, numbers):
    """One tick of the motion of every robot."""
    for i in range(situations.shape[0]):
        steer(situations[i], readings[i], heard[i], wheels[i], courses[i], numbers)


class Walkers:
    """Robots that subsumption moves, told tick by tick what they see and believe."""

    def __init__(self, numbers_of, rows, **parameters):
        layer = SubsumptionParameters(gap=0.04, hold=0.5, **parameters).layer(find_scenario("es1"))
        self.courses = layer.memory.array((rows,)).view(np.recarray)
        self.courses.stream[:, 0] = streams(range(rows), 1, layer.noise)
        self._situation = Situation.array((rows,)).view(np.recarray)
        self._readings = Readings.array((rows,)).view(np.recarray)
        self._heard = Heard.array((rows,), slots=4)
        self._wheels = np.zeros((rows, 2), np.float32)
        self._numbers = numbers_of(layer.numbers)

    def __call__(self, proximity=0.0):
        """The wheels of every robot, which has no goal, in a tick."""
        self._situation.goal[:] = np.eye(3)[-1]
        self._readings.proximity[:] = proximity
        steer_all(
            self._situation, self._readings, self._heard, self._wheels, self.courses, self._numbers
        )
        return self._wheels.copy()


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


def test_the_literal_rule_turns_opposite_to_the_obstacle(numbers_of):
    # TR 5.1
    (wheels,) = Walkers(numbers_of, 1, avoidance="literal")(seen({FRONT_LEFT: 0.5}))
    opposite = wheels_towards(math.radians(17.0 - 180.0), 0.15)
    np.testing.assert_allclose(wheels, opposite, rtol=1e-6)


def test_without_a_goal_robots_run_straight_and_turn_to_any_direction(numbers_of):
    rows, ticks, mean = 200, 600, 0.3
    run, turns = Walkers(numbers_of, rows, mean_run=mean), []
    for _ in range(ticks):
        before = run.courses.stream[:, 0].copy()
        run()
        after = run.courses.stream[:, 0]
        drawn = after[after != before] - GOLDEN  # the turn is the last draw
        turns.extend(math.pi * symmetric(drawn, i) for i in range(len(drawn)))
    path = find_scenario("es1").robot.cruise_speed * 0.1 * ticks * rows
    assert path / (len(turns) - rows) == pytest.approx(mean, rel=0.05)
    assert stats.kstest(turns, stats.uniform(-math.pi, 2.0 * math.pi).cdf).pvalue > 1e-4
