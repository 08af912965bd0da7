"""Subsumption motion: talk, avoid, forage, wander, in this order."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from baselines.motion.subsumption import SubsumptionParameters, obstacle, steer, way_round
from swarm_forage_env.kernels.proximity import PROXIMITY_ANGLES, response
from swarm_forage_env.kernels.rng import GOLDEN, symmetric
from swarm_forage_env.scenarios import find_scenario

SECTOR = math.radians(100.0)
FRONT_RIGHT, RIGHT, BACK, LEFT, FRONT_LEFT = 0, 2, 3, 5, 7


@pytest.fixture
def motion():
    """The running motion of so many robots, one to a world."""

    def start(rows=1, seed=0, **parameters):
        scenario = find_scenario("es1", {"n_robots": 1})
        chosen = SubsumptionParameters(**{"gap": 0.04, "hold": 0.5, **parameters})
        return chosen.start(scenario, range(seed, seed + rows))

    return start


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
    assert steer(angle, creep) == pytest.approx(wheels)


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 1.0))
def test_steering_stays_within_the_wheels_turns_the_right_way_and_is_symmetric(angle, creep):
    left, right = steer(angle, creep)
    assert max(abs(left), abs(right)) <= 1.0
    assert (right - left) * angle >= 0.0
    assert left + right >= -1e-12
    assert steer(-angle, creep) == pytest.approx((right, left))


def seen(**sensors):
    reading = np.zeros(8, np.float32)
    for name, value in sensors.items():
        reading[globals()[name.upper()]] = value
    return reading


@pytest.mark.parametrize(
    ("reading", "bearing"),
    [
        (seen(front_left=0.5, front_right=0.5), 0.0),
        (seen(left=0.9), math.pi / 2),
        (seen(right=0.9), -math.pi / 2),
        (seen(front_right=0.4), math.radians(-17.0)),
        (seen(left=0.5, right=0.5, front_left=0.1), math.radians(17.0)),
        (seen(front_left=0.5, back=1.0), math.radians(17.0)),
    ],
)
def test_the_bearing_of_an_obstacle_is_that_of_the_vector_sum(reading, bearing):
    assert obstacle(reading, 0.05, SECTOR) == pytest.approx((True, bearing), abs=1e-6)


@pytest.mark.parametrize("reading", [seen(), seen(back=1.0), seen(front_left=0.05)])
def test_what_is_weak_or_behind_is_no_obstacle(reading):
    assert obstacle(reading, 0.06, SECTOR) == (False, 0.0)


@pytest.mark.parametrize(
    ("bearing", "course"), [(0.0, -100.0), (20.0, -80.0), (90.0, -10.0), (-29.0, -129.0),
                            (-31.0, 69.0), (-90.0, 10.0)]
)  # fmt: skip
def test_the_way_round_keeps_right_unless_the_obstacle_is_there(bearing, course):
    swerve = math.radians(100.0)
    assert math.degrees(way_round(math.radians(bearing), swerve)) == pytest.approx(course)


def test_who_talks_stands_still_whatever_else_there_is(motion, situation):
    wheels = motion()(situation(talking=True, proximity=0.9, goal=1, target=[1.0, 0.0]))
    assert wheels.tolist() == [[0.0, 0.0]]


def test_who_has_a_goal_heads_for_it(motion, situation):
    wheels = motion(3)(
        situation(3, goal=1, target=[[1.0, 0.0], [0.0, 1.0], [math.cos(0.25), -math.sin(0.25)]])
    )
    expected = [steer(0.0, 0.0), steer(math.pi / 2, 0.0), steer(-0.25, 0.0)]
    np.testing.assert_allclose(wheels, expected, rtol=1e-6, atol=1e-7)


def test_avoiding_comes_before_the_goal_and_lasts_a_while(motion, situation):
    run = motion(hold=0.5)
    goal = {"goal": 1, "target": [1.0, 0.0]}
    wheels = run(situation(proximity=seen(front_left=0.5, front_right=0.5), **goal))
    np.testing.assert_allclose(wheels[0], steer(math.radians(-100.0), 0.15), rtol=1e-6)
    kept = [run(situation(**goal))[0].tolist() != [1.0, 1.0] for _ in range(6)]
    assert kept == [True] * 4 + [False] * 2


def test_the_held_course_is_an_angle_of_the_floor_and_not_of_the_body(motion, situation):
    robot = find_scenario("es1").robot
    run = motion(hold=10.0)
    wheels = [run(situation(proximity=seen(front_left=0.5, front_right=0.5)))[0].astype(float)]
    wheels += [run(situation())[0].astype(float) for _ in range(90)]
    left, right = np.array(wheels).T
    turned = np.sum(right - left) * robot.cruise_speed * 0.1 / robot.axle
    assert math.degrees(turned) == pytest.approx(-100.0, abs=0.1)
    assert left[-1] == pytest.approx(right[-1], abs=1e-3)


def test_the_literal_rule_turns_opposite_to_the_obstacle(motion, situation):
    # TR 5.1
    wheels = motion(avoidance="literal")(situation(proximity=seen(front_left=0.5)))
    np.testing.assert_allclose(wheels[0], steer(math.radians(17.0 - 180.0), 0.15), rtol=1e-6)


def test_an_obstacle_beyond_the_gap_is_let_be(motion, situation):
    goal = {"goal": 1, "target": [1.0, 0.0]}
    for gap, met in ((0.039, True), (0.041, False)):
        reading = seen(front_left=response(gap))
        wheels = motion(gap=0.04)(situation(proximity=reading, **goal))
        assert (wheels[0].tolist() != [1.0, 1.0]) == met


def test_all_sensors_of_the_front_half_are_in_the_sector():
    inside = np.abs(PROXIMITY_ANGLES) <= SECTOR
    assert inside.tolist() == [True, True, True, False, False, True, True, True]


def test_without_a_goal_robots_run_straight_and_turn_to_any_direction(motion, situation):
    rows, ticks, mean = 200, 600, 0.3
    run, nothing, turns = motion(rows, mean_run=mean), situation(rows), []
    for _ in range(ticks):
        before = run._streams.copy()
        run(nothing)
        drawn = run._streams[run._streams != before] - GOLDEN  # the turn is the last draw
        turns.extend(math.pi * symmetric(drawn, i) for i in range(len(drawn)))
    path = find_scenario("es1").robot.cruise_speed * 0.1 * ticks * rows
    assert path / (len(turns) - rows) == pytest.approx(mean, rel=0.05)
    assert stats.kstest(turns, stats.uniform(-math.pi, 2.0 * math.pi).cdf).pvalue > 1e-4


def test_a_random_walk_begins_by_turning_and_goes_on_straight(motion, situation):
    run = motion(50, mean_run=100.0)
    wheels = np.array([run(situation(50)) for _ in range(100)])
    spins = wheels[0, :, 0] != wheels[0, :, 1]
    assert spins.all()
    np.testing.assert_allclose(wheels[-1], 1.0, atol=1e-3)


def test_each_robot_walks_its_own_way_and_again_after_a_reset(motion, situation):
    run = motion(5, seed=3)
    first = np.array([run(situation(5)) for _ in range(100)])
    assert len({walk.tobytes() for walk in first.transpose(1, 0, 2)}) == 5
    for world in range(5):
        run.reset(world, 3 + world)
    again = np.array([run(situation(5)) for _ in range(100)])
    np.testing.assert_array_equal(first, again)
    run.reset(1, 9)
    other = np.array([run(situation(5)) for _ in range(100)])
    assert not np.array_equal(other[:, 1], first[:, 1])
