"""The waypoints world's equations: limits, sights, fixes, claims, devices, and steering."""

import math

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy import stats

from swarm_forage_env.compiler import bind
from swarm_forage_env.record import rows as as_rows
from swarm_forage_env.ticks import BEGINS, only, run_ticks
from swarm_forage_env.waypoints.records import (
    ENCODER,
    GOAL,
    LANDMARK,
    LIDAR,
    RobotState,
    Sighting,
    WorldState,
)
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.tick import (
    draw_devices,
    fix_at_home,
    judge_claim,
    limited,
    measure_motion,
    place_at_home,
    tick_world,
    turn_then_go,
)
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


def check_standard_normals(errors, believable):
    """Rows of errors over their deviations are normal, and no two of them correlated."""
    for error in errors:
        believable(stats.kstest(error, stats.norm.cdf).pvalue)
    check_uncorrelated(errors)


def check_uncorrelated(rows):
    correlations = np.corrcoef(rows)[np.triu_indices(len(rows), 1)]
    assert np.abs(correlations).max() < 4.0 / math.sqrt(len(rows[0]))


def test_wheels_and_gyro_have_their_own_bias_and_noise(fresh, believable):
    rows = 20_000
    robots = robots_with(rows, motion=[0.4, -0.3], deviation=[0.05, 0.02], bias=[0.01, -0.05])
    robots.streams[:, ENCODER] = fresh(rows)
    for robot in robots:
        measure_motion(robot)
    errors = (robots.readings.motion - robots.motion - robots.bias) / robots.deviation
    check_standard_normals(errors.T, believable)


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
    modes, trouble = np.full(len(robots), BEGINS, np.int8), np.zeros(len(robots) + 1, np.int64)
    arrays = robots, found, worlds, np.zeros(robots.shape)
    tick = bind(run_ticks, {**only("tick"), "tick_world": tick_world})
    tick(arrays, (), modes, trouble, 0, len(robots), 1)
    streams[:] = robots["streams"][..., LIDAR].reshape(-1)
    shape = len(pose), n_robots
    return tuple(found[name].reshape(shape) for name in ("seen", "range", "bearing"))


def test_range_and_bearing_are_normal_about_the_truth_for_each_robot_alone(fresh, believable):
    worlds = 10_000
    pose = np.tile([[0.0, 0.0, 0.3], [0.3, 0.4, -2.0]], (worlds, 1))
    seen, far, bearing = sights(pose, 2, fresh(2 * worlds))
    assert seen[0::2, 1].all()
    assert seen[1::2, 0].all()
    way = math.atan2(0.4, 0.3)
    errors = np.array([
        (far[0::2, 1] - 0.5) / 0.01,
        (bearing[0::2, 1] - (way - 0.3)) / 0.02,
        (far[1::2, 0] - 0.5) / 0.01,
        (bearing[1::2, 0] - (way - math.pi + 2.0)) / 0.02,
    ])  # fmt: skip
    check_standard_normals(errors, believable)


@pytest.mark.parametrize("d", [0.98, 0.995, 1.0, 1.01])
def test_the_measured_range_and_not_the_true_one_decides_who_is_seen(d, fresh, believable):
    worlds = 5000
    seen, far, _ = sights(np.tile([[0, 0, 0], [d, 0, 0]], (worlds, 1)), 2, fresh(2 * worlds))
    share = stats.norm.cdf((1.0 - d) / 0.01)
    believable(stats.binomtest(int(seen.sum()), 2 * worlds, share).pvalue)
    assert far.max() <= 1.0


def test_what_is_not_seen_holds_zeros_and_draws_nothing_when_far(fresh):
    streams = fresh(2)
    before = streams.copy()
    seen, far, bearing = sights([[0, 0, 0], [1.09, 0, 0]], 2, streams)
    assert not seen.any()
    assert not far.any()
    assert not bearing.any()
    assert_array_equal(streams, before)
    sights([[0, 0, 0], [1.07, 0, 0]], 2, streams)
    assert np.all(streams != before)


def fixes(pose, streams, noise=0.001):
    robots = robots_with(len(pose), pose=pose)
    robots.readings.home_fix[:] = 1.0
    robots.streams[:, LANDMARK] = streams
    for robot in robots:
        fix_at_home(robot, world_with(home_noise=noise))
    return robots.readings.at_home, robots.readings.home_fix


def test_home_tells_the_pose_within_reach_and_zeros_beyond(fresh):
    pose = [[0.6, 0.7, 1.0], [0.6, 0.8, 1.0], [0.0, 0.0, -2.0], [-3.0, 0.1, 2.0]]
    at_home, fix = fixes(pose, fresh(4), noise=0.0)
    assert at_home.tolist() == [True, False, True, False]
    assert_array_equal(fix, np.array([pose[0], [0, 0, 0], pose[2], [0, 0, 0]], np.float32))


def test_the_fix_is_normal_about_the_pose(fresh, believable):
    pose = np.tile([0.3, -0.4, 1.0], (10_000, 1))
    at_home, fix = fixes(pose, fresh(10_000), noise=0.1)
    assert at_home.all()
    check_standard_normals(((fix - pose) / 0.1).T, believable)


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


def test_new_goals_are_uniform_in_the_square(fresh, believable):
    rows = 10_000
    *_, goal = judged([True] * rows, np.zeros((rows, 3)), np.zeros((rows, 2)), fresh(rows))
    for axis in goal.T:
        believable(stats.kstest(axis, stats.uniform(-5.0, 10.0).cdf).pvalue)
    check_uncorrelated(goal.T)


def test_robots_start_about_home_and_their_first_goals_are_ahead_in_x_and_y(fresh, believable):
    rows = 5000
    robots, places = robots_with(rows), fresh(rows, 1)
    robots.streams[:, GOAL] = fresh(rows, 2)
    for i, robot in enumerate(robots):
        place_at_home(robot, WORLD, places, i)
    for axis, half in zip(robots.pose.T, (1.0, 1.0, math.pi), strict=True):
        believable(stats.kstest(axis, stats.uniform(-half, 2.0 * half).cdf).pvalue)
    for axis in robots.goal.T:
        believable(stats.kstest(axis, stats.uniform(1.0, 4.0).cdf).pvalue)
    assert_array_equal(robots.motion, np.tile([0.5, 0.0], (rows, 1)))


def test_devices_differ_in_noise_by_the_spread_and_in_bias_by_its_deviation(fresh, believable):
    robots, streams = robots_with(10_000), fresh(10_000)
    world = world_with(noise=[0.05, 0.02], bias=[0.005, 0.05], spread=0.01)
    for i, robot in enumerate(robots):
        draw_devices(robot, world, streams, i)
    for found, size in zip(robots.deviation.T, (0.05, 0.02), strict=True):
        believable(stats.kstest(found / size, stats.uniform(0.99, 0.02).cdf).pvalue)
    check_standard_normals((robots.bias / [0.005, 0.05]).T, believable)
    check_uncorrelated([*robots.deviation.T, *robots.bias.T])
