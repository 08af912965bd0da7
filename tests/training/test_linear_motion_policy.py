"""The linear motion policy: features by hand, zeros are subsumption, candidates are independent."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from tests.training.test_learned_networks import numbers_of, one
from training.candidate_rollouts import Candidate
from training.linear_motion_policy import (
    FEATURES,
    LINEAR_MOTION,
    N_WEIGHTS,
    SearchCourse,
    message_features,
    policy_output,
    steer,
    write_features,
)

BUSY = {"task.area_distance": 0.62, "robot.cruise_speed": 0.12, "radio.max_range": 0.5}
SCENARIO = find_scenario("es1", {"task.n_robots": 4, **BUSY})
N = len(FEATURES)


def numbers(seed, spread=0.2):
    return np.random.default_rng(seed).normal(0.0, spread, N_WEIGHTS).astype(np.float32)


def loop_with(seeds, *candidates):
    """A loop of the layers by hand, or of one candidate for all worlds or for each."""
    plain = find_controller("ssgiff")
    controllers = [replace(plain, **candidate) for candidate in candidates]
    if len(candidates) < len(seeds):
        (controllers,) = controllers or [plain]
    return Loop(SCENARIO, controllers, seeds, "kinematic")


def motion(found):
    """A candidate of these numbers."""
    return {"motion": Candidate(found, LINEAR_MOTION)}


def felt(sense, *given):
    x = np.zeros(N)
    sense(*given, x)
    return dict(zip(FEATURES, x.tolist(), strict=True))


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 1, 0], [1, 2, 0]])
def test_the_nearest_sender_is_heard_whatever_the_order(order):
    heard = Heard.array((1,), slots=4).view(np.recarray)[0]
    beam = np.array([[0.3, 0, 0], [0.05, math.pi / 2, 0], [0.1, 3, 0]], np.float32)
    heard.n, heard.range_bearing[:3] = 3, beam[order]
    x = felt(message_features, heard, 4.0)
    expected = (0.15 / 0.2, 0.0, 0.75)
    assert (x["robot_left"], x["robot_ahead"], x["robots"]) == pytest.approx(expected, abs=1e-6)
    heard.n = 0
    assert not any(felt(message_features, heard, 4.0).values())


def test_zeros_are_subsumption_to_the_last_bit():
    own, linear = loop_with([1, 2]), loop_with([1, 2], motion(np.zeros(N_WEIGHTS)))
    for each in (own, linear):
        each.run(1500)
    assert own.world.state.round_trips.sum() > 0
    assert_array_equal(linear.world.state.pose, own.world.state.pose)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (motion(numbers(0)), motion(numbers(1))),
        tuple({"weighting": Candidate(own * np.ones(50))} for own in (-1.0, 1.0)),
    ],
    ids=["motion", "weighting"],
)
def test_a_candidate_does_in_a_block_what_it_does_alone(one, other):
    block = loop_with([5, 5, 6], one, other, other)
    alone = [loop_with([5], one), loop_with([5], other), loop_with([6], other)]
    for _ in range(1500):
        for loop in (block, *alone):
            loop.step()
    poses = np.concatenate([loop.world.state.pose for loop in alone])
    assert_array_equal(block.world.state.pose, poses)
    assert (poses[:4] != poses[4:8]).any()


def test_a_new_episode_forgets_how_far_robots_have_searched():
    loop = loop_with([1, 2], motion(numbers(0)))
    loop.run(10)
    searched = loop.controller.minds["motion"]["searched"]
    assert (searched > 0.0).all()
    loop.controller.reset(1, 2, [7])
    assert (searched[0] > 0.0).all()
    assert not searched[1].any()


ES1 = find_scenario("es1")


def seen(goal, talking=False):
    """What a robot believes, feels and hears: one sender ahead, something close to its left."""
    situation = one(Situation, target=(0.3, 0.4), p=(1.0, 3.0), is_talking=talking)
    situation.goal[:] = np.eye(3)[goal]
    readings = one(Readings)
    readings.proximity[6] = 0.1
    heard = one(Heard, n=1, sizes={"slots": 4})
    heard.range_bearing[0] = (0.45, 0.0, 0.0)
    return situation, readings, heard


def test_the_features_of_a_tick_by_hand():
    memory = one(SearchCourse, searched=2.0)
    memory.features[:] = 9.0  # of the tick before
    wheels = np.array([0.2, 0.8], np.float32)
    write_features(*seen(1), wheels, memory, 4.0)
    side, ahead = math.sin(math.radians(50.0)), math.cos(math.radians(50.0))
    expected = [1.0, 0.8, 0.6, 0.15 / 0.65, 3.0 / 5.0, 0.1 * side, 0.1 * ahead, 0.0]
    assert memory.features[:8] == pytest.approx(expected, abs=1e-5)
    assert memory.features[8:] == pytest.approx([0.0, 0.25, 0.25, 0.3], abs=1e-6)
    write_features(*seen(0), wheels, memory, 4.0)
    assert memory.features[3:5] == pytest.approx([0.15 / 0.65, 1.0 / 3.0], abs=1e-5)
    write_features(*seen(-1), wheels, memory, 4.0)
    expected = [1.0, 0.0, 0.0, 0.15 / 2.15, 2.0 / 4.0]
    assert memory.features[:5] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("goal", "mode"), [(0, 0), (-1, 1)])
def test_a_policy_corrects_subsumption_and_not_a_robot_that_talks(goal, mode):
    policy = np.zeros(N_WEIGHTS)
    policy[2 * mode * N] = math.atanh(-0.25)  # back, whatever is sensed
    wheels = {}
    for talking in (False, True):
        for own in (np.zeros(N_WEIGHTS), policy):
            numbers = numbers_of(LINEAR_MOTION.layer(own, ES1).numbers)
            found = np.array([1.0, 1.0], np.float32)
            steer(*seen(goal, talking), found, one(SearchCourse, run=1.0), numbers)
            wheels[talking, bool(own.any())] = found
    expected = np.maximum(wheels[False, False] - 0.5, -1.0)
    np.testing.assert_allclose(wheels[False, True], expected, atol=1e-6)
    np.testing.assert_array_equal(wheels[True, True], wheels[True, False])


@pytest.mark.parametrize(
    ("forward", "turning", "wheels"),
    [
        (0.75, 0.5, (0.25, 1.0)), (0.75, -0.5, (1.0, 0.25)),
        (-0.75, 0.5, (-1.0, -0.25)), (-0.75, -0.5, (-0.25, -1.0)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("mode", [0, 1])
def test_residuals_are_bounded_on_both_wheels_and_the_last_feature_counts(
    forward, turning, wheels, mode
):
    numbers, x = np.zeros(N_WEIGHTS), np.zeros(N)
    x[-1] = 0.5
    numbers[(2 * mode + 1) * N - 1] = 2.0 * math.atanh(forward)
    numbers[(2 * mode + 2) * N - 1] = 2.0 * math.atanh(turning)
    numbers[5 * N - 1] = -2.0
    run = 10.0 ** -math.tanh(1.0)
    assert policy_output(x, numbers, mode) == pytest.approx((*wheels, run))
