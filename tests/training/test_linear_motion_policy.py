"""The linear motion policy: features by hand, zeros are subsumption, candidates are independent."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.records import Heard
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario
from training.candidate_rollouts import CandidateMotion
from training.learned_weighting import unflatten
from training.linear_motion_policy import (
    FEATURES,
    N_WEIGHTS,
    NETWORK,
    SHAPES,
    goal_features,
    message_features,
    policy_output,
    proximity_features,
)
from training.policy_file import layer_card, save_policy

SCENARIO = find_scenario(
    "es1", {"task.n_robots": 4, "task.area_distance": 0.62, "robot.cruise_speed": 0.12}
)
N = len(FEATURES)


def numbers(seed, spread=0.2):
    return np.random.default_rng(seed).normal(0.0, spread, N_WEIGHTS).astype(np.float32)


def loop_with(seeds, *candidates):
    """A loop of subsumption, or of one candidate for all worlds or for each."""
    plain = find_controller("ssgiff")
    controllers = [replace(plain, motion=CandidateMotion(each)) for each in candidates]
    if len(candidates) < len(seeds):
        (controllers,) = controllers or [plain]
    return Loop(SCENARIO, controllers, seeds, "kinematic")


def felt(sense, *given):
    x = np.zeros(N)
    sense(*given, x)
    return dict(zip(FEATURES, x.tolist(), strict=True))


def test_a_goal_is_seen_by_its_direction_and_distance():
    x = felt(goal_features, np.array([0.0, 0.15], np.float32), 2.0, -1.0)
    assert (x["target_left"], x["target_ahead"]) == pytest.approx((1.0, 0.0), abs=1e-4)
    assert (x["near"], x["unsure"]) == pytest.approx((0.5, 0.5))


def test_without_a_goal_the_path_walked_takes_the_place_of_the_distance():
    x = felt(goal_features, np.array([9.0, 9.0], np.float32), 0.0, 0.45)
    assert x["target_left"] == x["target_ahead"] == 0.0
    assert (x["near"], x["unsure"]) == pytest.approx((0.25, 0.45 / 2.45))


def test_what_is_close_on_the_left_is_felt_on_the_left():
    proximity = np.zeros(8, np.float32)
    proximity[[5, 6]] = 0.5  # sensors of the e-puck's left flank
    x = felt(proximity_features, proximity)
    mirrored = felt(proximity_features, proximity[::-1].copy())
    assert x["obstacle_left"] > x["obstacle_ahead"] > 0.0 == x["obstacle_right"]
    assert mirrored["obstacle_right"] == pytest.approx(x["obstacle_left"])


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 1, 0], [1, 2, 0]])
def test_the_nearest_sender_is_heard_whatever_the_order(order):
    heard = Heard.array((1,), slots=4).view(np.recarray)[0]
    beam = np.array([[0.3, 0, 0], [0.05, math.pi / 2, 0], [0.1, 3, 0]], np.float32)
    heard.n, heard.range_bearing[:3] = 3, beam[order]
    x = felt(message_features, heard, 4.0)
    expected = (0.15 / 0.2, 0.0, 0.75)
    assert (x["robot_left"], x["robot_ahead"], x["robots"]) == pytest.approx(expected, abs=1e-6)


def test_an_output_is_the_tanh_of_its_row():
    x, w = np.zeros(N), np.zeros(N_WEIGHTS)
    x[0] = 1.0
    w[0], w[N], w[2 * N], w[3 * N], w[4 * N] = 0.1, 0.3, -0.2, 0.0, 0.5
    forward, turning = math.tanh(0.1), math.tanh(0.3)
    run = 10.0 ** math.tanh(0.5)
    assert policy_output(x, w, 0) == pytest.approx((forward - turning, forward + turning, run))
    assert policy_output(x, w, 1) == pytest.approx((math.tanh(-0.2), math.tanh(-0.2), run))


def test_zeros_are_subsumption_to_the_last_bit():
    own, linear = loop_with([1, 2]), loop_with([1, 2], np.zeros(N_WEIGHTS))
    for _ in range(1500):
        own.step()
        linear.step()
    assert own.world.state.round_trips.sum() > 0
    assert_array_equal(linear.world.state.pose, own.world.state.pose)


def test_a_candidate_does_in_a_block_what_it_does_alone():
    one, other = numbers(0), numbers(1)
    block = loop_with([5, 5, 6], one, other, other)
    alone = [loop_with([5], one), loop_with([5], other), loop_with([6], other)]
    for _ in range(400):
        for loop in (block, *alone):
            loop.step()
    poses = np.concatenate([loop.world.state.pose for loop in alone])
    assert_array_equal(block.world.state.pose, poses)
    assert (poses[:4] != poses[4:8]).any()


@pytest.mark.parametrize("told", [-3.0, 3.0])
def test_straight_runs_get_longer_or_shorter(told):
    w = np.zeros(N_WEIGHTS)
    w[4 * N] = told
    loop = loop_with([1], w)
    for _ in range(20):
        loop.step()
    memory, situation = rows(loop.controller.minds["motion"]), loop.situation
    memory.run = 1.0
    loop.step()
    walks = (situation.goal[:, 2] > 0) & (memory.run < 1.0)
    step = SCENARIO.robot.cruise_speed * SCENARIO.tick
    assert walks.any()
    assert_allclose(1.0 - memory.run[walks], step / 10.0 ** math.tanh(told), rtol=1e-6)


def test_a_new_episode_forgets_how_far_robots_have_searched():
    loop = loop_with([1, 2], numbers(0))
    for _ in range(50):
        loop.step()
    searched = loop.controller.minds["motion"]["searched"]
    assert (searched > 0.0).all()
    loop.controller.reset(1, 7)
    assert (searched[0] > 0.0).all()
    assert not searched[1].any()


@pytest.fixture
def kept(tmp_path, make_card):
    """A file of a linear policy, with arrays left out if wanted."""

    def make(*names):
        arrays = unflatten(numbers(0), SHAPES)
        file = tmp_path / "mine.safetensors"
        card = make_card(layers={"motion": layer_card("motion", SCENARIO, NETWORK, {})})
        save_policy(file, {f"motion.{name}": arrays[name] for name in names}, card)
        return file

    return make


def test_a_linear_policy_in_a_file_runs_as_a_learned_motion(kept):
    file = kept(*SHAPES)
    named = Loop(SCENARIO, find_controller(f"learned-motion:policy={file}"), [3], "kinematic")
    loop = loop_with([3], numbers(0))
    for _ in range(300):
        named.step()
        loop.step()
    assert_array_equal(named.world.state.pose, loop.world.state.pose)


def test_a_linear_policy_that_lacks_an_array_is_refused(kept):
    with pytest.raises(ConfigError, match=r"array 'motion\.walk\.weight' is missing"):
        find_controller(f"learned-motion:policy={kept('steer.weight')}")
