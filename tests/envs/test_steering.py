"""Where a learner steers: the walk goes on, reflexes come first, and a course is steered."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from baselines.motion.subsumption import SubsumptionParameters, obstacle, way_round
from swarm_forage_env import ArrayEnv, ConfigError
from swarm_forage_env.equations.differential_drive import wheels_towards
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.equations.proximity import response
from swarm_forage_env.foraging.control import WIDEST_OFF_COURSE

TICKS = {"physics": "kinematic", "decision_period": 1}


def situations(env):
    return env.loop.controller.minds["estimator"]["situation"]


def talking(env):
    return situations(env)["is_talking"][0] > 0.0


def seen_by_reflexes(env):
    """Of every robot whether something is in its way, and the course past it."""
    numbers = SubsumptionParameters()
    for proximity in env.world.robots["readings"]["proximity"][0]:
        is_near, bearing = obstacle(proximity, response(numbers.gap), numbers.sector)
        yield is_near, way_round(bearing, numbers.swerve, 0.0) if is_near else math.nan


@pytest.fixture
def driven(busy):
    """An environment of one world, and the drives of its robots: most of the time ahead."""

    def made(**options):
        env = ArrayEnv(busy, 1, **TICKS, **options)
        env.reset(3)
        rng = np.random.default_rng(0)
        return env, lambda: rng.uniform(-0.5, 1.0, (1, len(env.learners), 2)).astype(np.float32)

    return made


def test_the_walk_turns_against_the_robot_and_is_drawn_anew_after_a_run(driven):
    env, draw = driven(action="wheels")
    scenario, kept, n_walked = env.world.scenario, 0, 0
    by = scenario.robot.cruise_speed * scenario.tick / scenario.robot.axle
    for _ in range(400):
        before, goal = situations(env)["walk"][0].copy(), situations(env)["goal"][0, :, 2] > 0.0
        wheels = draw()
        env.step(wheels)
        after = situations(env)["walk"][0]
        turned = by * (wheels[0, :, 1].astype(float) - wheels[0, :, 0])
        new = np.arctan2(after[:, 1], after[:, 0]) - np.arctan2(before[:, 1], before[:, 0]) + turned
        is_same = np.abs((new + math.pi) % (2.0 * math.pi) - math.pi) < 1e-5
        assert is_same[~goal].all()  # a robot with a goal is on no walk
        kept, n_walked = kept + int(is_same[goal].sum()), n_walked + int(goal.sum())
    assert len(np.unique(after, axis=0)) == len(after), "every robot has a walk of its own"
    mean_run = SubsumptionParameters().mean_run / (scenario.robot.cruise_speed * scenario.tick)
    assert 0.5 / mean_run < 1.0 - kept / n_walked < 2.0 / mean_run


def test_reflexes_stand_while_talking_and_go_round_what_is_near(driven):
    env, draw = driven()
    stood = avoided = 0
    for _ in range(1500):
        is_talking, before = talking(env), list(seen_by_reflexes(env))
        env.step(draw())
        wheels = env.world.robots["command"]["wheels"][0]
        assert_array_equal(wheels[is_talking], 0.0)
        for robot in np.flatnonzero(~is_talking):
            is_near, angle = before[robot]
            if is_near:
                assert_allclose(wheels[robot], wheels_towards(angle, 0.15), atol=1e-6)
                avoided += 1
        stood += int(is_talking.sum())
    assert stood > 20
    assert avoided > 20


def test_without_reflexes_the_policy_alone_drives(driven):
    env, draw = driven(reflexes=False, action="drive-v1")
    was_talking = False
    for _ in range(1500):
        was_talking |= bool(talking(env).any())
        given = draw().astype(np.float64)
        env.step(given)
        ahead, turn = 0.5 * (given[0, :, :1] + 1.0), 0.3 * given[0, :, 1:] * [-1.0, 1.0]
        wanted = (ahead + turn) / np.maximum(1.0, np.abs(ahead) + np.abs(turn))
        assert_allclose(env.world.robots["command"]["wheels"][0], wanted, atol=1e-6)
    assert was_talking


def test_a_course_is_an_angle_off_the_way_to_the_target_or_of_the_walk(driven):
    env, draw = driven(action="course")
    with_goal = without = 0
    for _ in range(600):
        now, is_talking = situations(env)[0].copy(), talking(env)
        is_near = np.array([each for each, _ in seen_by_reflexes(env)])
        given = draw()
        env.step(given)
        wheels = env.world.robots["command"]["wheels"][0]
        for robot in np.flatnonzero(~is_talking & ~is_near):
            has_goal = now["goal"][robot, 2] == 0.0
            course = now["target" if has_goal else "walk"][robot].astype(float)
            angle = wrap(math.atan2(course[1], course[0]) + given[0, robot, 1] * WIDEST_OFF_COURSE)
            speed = min(1.0, 1.0 + given[0, robot, 0])
            wanted = speed * np.array(wheels_towards(angle, 0.0))
            assert_allclose(wheels[robot], wanted, atol=1e-6)
            with_goal, without = with_goal + has_goal, without + (not has_goal)
    assert min(with_goal, without) > 100


def test_a_correction_has_its_size(busy):
    envs = [ArrayEnv(busy, 1, residual=size, **TICKS) for size in (0.25, 1.0)]
    given = np.random.default_rng(0).uniform(-0.2, 0.2, (300, 1, 10, 2)).astype(np.float32)
    seen = [env.reset(3)[0] for env in envs]
    for correction in given:
        by_size = zip(envs, (correction, correction * np.float32(0.25)), strict=True)
        seen = [env.step(each)[0] for env, each in by_size]
        assert_array_equal(*seen)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"learn": "weighting", "reflexes": True}, "reflexes=True: needs a hand-written motion"),
        ({"learn": "everything", "action": "course"}, "action='course': needs a hand-written"),
        ({"scenario": "waypoints-05", "reflexes": True}, "learn='motion' in a foraging scenario"),
        ({"action": "course", "reflexes": False}, "reflexes=False: action='course' is steered by"),
        ({"residual": True, "reflexes": False}, "reflexes: a residual policy corrects a hand-"),
    ],
)
def test_steering_that_cannot_be_had_is_refused(options, message):
    with pytest.raises(ConfigError, match=message):
        ArrayEnv(**{"scenario": "es1", "n_worlds": 1, **options})
