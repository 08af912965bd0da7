"""The waypoints world's equations: limits, sights, fixes, claims, devices, and steering."""

import math

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.compiler import bind
from swarm_forage_env.equations.random_draws import normal
from swarm_forage_env.record import rows as as_rows
from swarm_forage_env.ticks import START, only, run_ticks
from swarm_forage_env.waypoints.records import GOAL, LIDAR, RobotState, Sighting, WorldState
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.tick import judge_claim, limited, tick_world, turn_then_go
from swarm_forage_env.waypoints.world import write_numbers


def world_with(**numbers):
    """The numbers of the default scenario, with some of them changed."""
    worlds = as_rows(WorldState.array((1,)))
    write_numbers(WaypointsScenario(), worlds[0])
    for name, value in numbers.items():
        worlds[0][name] = value
    return worlds[0]


def robots_with(rows, **columns):
    """Robots of which some fields are given."""
    robots = as_rows(RobotState.array((rows,)))
    for name, values in columns.items():
        robots[name] = values
    return robots


WORLD = world_with()
DT = 0.5


@pytest.mark.parametrize(
    ("speed", "ahead", "left", "expected"),
    [
        (0.5, 1.0, 0.0, (0.5, 0.0)),
        (0.01, 1.0, 0.0, (0.5, 0.0)),
        (0.5, -1.0, 0.0, (0.01, 1.0)),
        (0.3, 0.02, 0.01, (0.35, math.atan(0.5))),
        (0.3, 0.02, -0.01, (0.35, -math.atan(0.5))),
        (0.3, -0.02, 0.001, (0.25, 1.0)),
        (0.3, 0.0, 1.0, (0.3, 1.0)),
        (0.3, 0.0, -1.0, (0.3, -1.0)),
        (0.3, 0.0, 0.0, (0.3, 0.0)),
        (0.3, 0.04, 0.04, (0.4, math.pi / 4.0)),
    ],
)
def test_an_acceleration_changes_speed_by_its_share_and_course_by_its_angle_within_limits(
    speed, ahead, left, expected
):
    assert limited(speed, ahead, left, WORLD) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("theta", "speed", "turn", "expected"),
    [
        (0.0, 0.4, 0.0, (1.2, 2.0, 0.0)),
        (0.0, 0.4, math.pi, (1.0, 2.2, math.pi / 2)),
        (0.0, 0.4, -math.pi, (1.0, 1.8, -math.pi / 2)),
        (math.pi / 2, 0.4, math.pi, (0.8, 2.0, -math.pi)),
        (3.0, 0.0, 1.0, (1.0, 2.0, 3.5 - 2.0 * math.pi)),
    ],
)
def test_a_robot_turns_first_and_then_goes_straight(theta, speed, turn, expected):
    assert turn_then_go(1.0, 2.0, theta, speed, turn, DT) == pytest.approx(expected)


def drawn(draw, streams, n):
    """The next n draws of each stream, a row for each."""
    return np.array([[draw(streams, i) for _ in range(n)] for i in range(len(streams))])


def sights(pose, n_robots, streams, **numbers):
    """Who is seen, at which range and bearing, in worlds of so many robots."""
    pose = np.array(pose, float)
    robots = RobotState.array((len(pose) // n_robots, n_robots))
    robots["pose"] = pose.reshape(*robots.shape, 3)
    robots["streams"][..., LIDAR] = streams.reshape(robots.shape)
    found = Sighting.array((*robots.shape, n_robots))
    for name in ("seen", "range", "bearing"):
        found[name] = 1
    worlds = WorldState.array((len(robots),))
    worlds[:] = np.array(world_with(**numbers))
    modes, errors = np.full(len(robots), START, np.int8), np.zeros(len(robots) + 1, np.int64)
    arrays = robots, found, worlds, np.zeros(robots.shape)
    tick = bind(run_ticks, {**only("tick"), "tick_world": tick_world})
    tick(arrays, (), modes, errors, 0, len(robots), 1)
    streams[:] = robots["streams"][..., LIDAR].reshape(-1)
    shape = len(pose), n_robots
    return tuple(found[name].reshape(shape) for name in ("seen", "range", "bearing"))


@pytest.mark.parametrize("d", [0.98, 0.995, 1.0, 1.01])
def test_the_measured_range_and_not_the_true_one_decides_who_is_seen(d, fresh):
    seen, far, _ = sights(np.tile([[0, 0, 0], [d, 0, 0]], (50, 1)), 2, fresh(100))
    measured = d + 0.01 * drawn(normal, fresh(100), 1)[:, 0]
    assert_array_equal(seen.any(axis=1), measured < 1.0)
    assert 0 < seen.sum() < 100
    assert far.max() <= 1.0


def judged(claim, pose, goal, streams, tolerance=0.2):
    """Counters of right and wrong claims, rewards and goals afterwards."""
    robots = robots_with(len(claim), pose=pose, goal=goal, right=3, wrong=4, reward=9.0)
    robots.command.claim[:] = claim
    robots.streams[:, GOAL] = streams
    world = world_with(tolerance=tolerance, half_side=5.0)
    for robot in robots:
        judge_claim(robot, world)
    streams[:] = robots.streams[:, GOAL]
    return robots.right.tolist(), robots.wrong.tolist(), robots.reward.tolist(), robots.goal


def test_a_claim_is_right_within_the_tolerance_and_only_claimers_get_new_goals(fresh):
    pose = [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]]
    goal = [[1.1, 1.15], [1.2, 1.1], [1.0, 1.0], [4.0, 4.0]]
    claim = [True, True, False, False]
    streams = fresh(4)
    before = streams.copy()
    right, wrong, reward, after = judged(claim, pose, goal, streams)
    assert right == [4, 3, 3, 3]
    assert wrong == [4, 5, 4, 4]
    assert reward == [1.0, 0.0, 0.0, 0.0]
    assert_array_equal((after != goal).all(axis=1), claim)
    assert_array_equal(after[2:], goal[2:])
    assert_array_equal(streams != before, claim)
    at_the_tolerance = judged([True], [[0.0, 0.0, 0.0]], [[0.25, 0.0]], fresh(1), 0.25)
    assert at_the_tolerance[:3] == ([3], [5], [0.0])
