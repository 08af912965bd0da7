"""A learned motion: the same network in training and evaluation, whatever order it hears in."""

import math
import pickle
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal

from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting.rows import RowWeighting
from swarm_forage_env import ArrayEnv
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.mixed import MixedController
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.outside import OutsideMotion, exchanges, motion_inputs
from training.actor_critic import LayerPolicy, MotionActor, WeightingActor
from training.learned_motion import (
    NEAR,
    NetworkMotion,
    _message_features,
    wheel_speeds,
)
from training.learned_weighting import EXCHANGE_NETWORK, flatten
from training.policy_file import observation_layout

SCENARIO = find_scenario(
    "es1", {"task.n_robots": 4, "task.area_distance": 0.62, "robot.cruise_speed": 0.12}
)


LAYOUT = observation_layout("motion", SCENARIO)
COLUMNS = LAYOUT.columns("situation")


def environment(learn, seeds):
    options = {"physics": "kinematic", "action": "wheels", "normalise": False, "walk": False}
    return ArrayEnv(SCENARIO, len(seeds), "ssgiff", learn=learn, decision_period=1, **options)


@pytest.fixture(scope="module")
def observed():
    """Observations of a run in which robots wander, meet and know areas."""
    env = environment("motion", [1, 2])
    rows = len(LAYOUT)
    seen = [env.reset([1, 2])[0].reshape(-1, rows)]
    motion = OutsideMotion(SubsumptionParameters().layer(SCENARIO), SCENARIO, [1, 2])
    for _ in range(600):
        wheels = motion(*motion_inputs(LAYOUT.records(seen[-1]))).reshape(2, -1, 2)
        seen.append(env.step(wheels)[0].reshape(-1, rows))
    return np.concatenate(seen)


@pytest.fixture
def actor():
    torch.manual_seed(0)
    actor = MotionActor(LAYOUT)
    with torch.no_grad():
        for array in actor.parameters():
            array += 0.3 * torch.randn(array.shape)
    return actor


def test_the_run_holds_all_that_a_network_is_shown(observed):
    seen = LAYOUT.records(observed)
    assert seen["heard"].n.max() > 1
    assert seen["situation"].is_talking.any()
    assert seen["situation"].goal.any(axis=0).all()


def test_training_and_evaluation_agree(observed, actor):
    running = NetworkMotion(actor.to_numpy(), SCENARIO)
    wheels = running(*motion_inputs(LAYOUT.records(observed)))
    with torch.no_grad():
        means, moves = actor(torch.from_numpy(observed))
    assert_allclose(wheels, means.clip(-1.0, 1.0).numpy(), atol=1e-5)
    assert wheels.dtype == np.float32
    assert np.ptp(wheels) > 1.0
    assert (moves == 0.0).any()


@pytest.mark.parametrize("rows", [1, 3, 8, 50, 301])
def test_a_row_has_the_same_wheels_to_the_last_bit_whatever_rows_stand_beside_it(
    observed, actor, rows
):
    weights, columns = actor.to_numpy(), COLUMNS
    expected = wheel_speeds(weights, observed, columns, np)
    assert_array_equal(wheel_speeds(weights, observed[-rows:], columns, np), expected[-rows:])


def test_features_are_finite_where_everything_is_far_or_nothing_is_known(actor):
    box = LAYOUT.box()
    for corner in (box.low, box.high, np.zeros_like(box.low)):
        far = np.clip(corner, -1e6, 1e6)[None]
        assert np.isfinite(wheel_speeds(actor.to_numpy(), far, COLUMNS, np)).all()


def test_the_weighting_that_is_trained_is_the_one_that_runs():
    rng = np.random.default_rng(0)
    layout = environment("weighting", [1]).observation_layout
    n = 50
    path = lambda: rng.uniform(0.0, 9.0, (n, 2))  # noqa: E731 short
    one = rng.uniform(0.02, 1.0, n)
    encounter = exchanges(
        n, own_p=path(), heard_p=path(), disagreement=path(), own_distance=path(),
        heard_distance=path(), range=one, n_averaged=50.0 * one,
    )  # fmt: skip
    torch.manual_seed(0)
    actor = WeightingActor(layout)
    with torch.no_grad():
        for array in actor.parameters():
            array += 0.3 * torch.randn(array.shape)
        given, matters = actor(torch.from_numpy(layout.matrix({"exchange": encounter})))
    numbers = flatten(actor.to_numpy(), EXCHANGE_NETWORK.shapes(actor.sizes))
    assert_allclose(
        given.numpy(), RowWeighting(EXCHANGE_NETWORK.layer(numbers))(encounter), atol=1e-5
    )
    assert matters.all()


@pytest.mark.parametrize("learn", ["weighting", "motion", "both"])
def test_acts_without_effect_teach_the_actor_nothing(learn):
    layers = ("weighting", "motion") if learn == "both" else (learn,)
    env = environment(learn, [1])
    layout = env.observation_layout
    policy = LayerPolicy(layout, layers, -1.2)
    idle = torch.from_numpy(env.reset([1])[0][0])
    names = list(layout.names)
    if "motion" in layers:
        idle[:, names.index("situation.talking")] = 1.0
    actions = policy(idle)[0].detach()
    _, log_prob, _ = policy.evaluate_actions(idle, actions)
    log_prob.sum().backward()
    parameters = [*policy.actors.parameters(), policy.log_std]
    assert all(each.grad is None or not each.grad.any() for each in parameters)


def test_a_learned_motion_is_copied_with_what_it_writes_to():
    controller = find_controller("learned-motion:policy=motion-es1")
    loop, twin = (Loop(find_scenario("es1"), controller, [3, 4], "kinematic") for _ in range(2))
    assert loop.controller.has_rules
    for _ in range(30):
        loop.step()
        twin.step()
    copies = deepcopy(loop), pickle.loads(pickle.dumps(loop))
    for _ in range(60):
        for each in (twin, *copies):
            each.step()
    for each in copies:
        assert_array_equal(each.world.robots["pose"], twin.world.robots["pose"])


class Network:
    """A motion that runs a network of given weights."""

    def __init__(self, weights):
        self._weights = weights

    def start(self, scenario, seeds):
        return NetworkMotion(self._weights, scenario)


def test_two_networks_and_a_hand_written_motion_in_one_swarm_steer_their_own_robots(actor):
    weights = actor.to_numpy()
    turned = {**weights, "wheels.weight": -weights["wheels.weight"]}
    compiled = CONTROLLERS["ssgiff"]
    one, other = (replace(compiled, motion=Network(each)) for each in (weights, turned))
    loop = Loop(SCENARIO, MixedController((one, other, compiled, one)), [1, 2], "kinematic")
    networks = [NetworkMotion(each, SCENARIO) for each in (weights, turned)]
    for _ in range(200):
        state = loop.world.state
        seen = loop.situation, state.readings, state.heard, state.command.wheels
        expected = [network(*seen) for network in networks]
        loop.step()
        wheels = loop.world.state.command.wheels
        assert_array_equal(wheels[[0, 3, 4, 7]], expected[0][[0, 3, 4, 7]])
        assert_array_equal(wheels[[1, 5]], expected[1][[1, 5]])
        assert np.any(expected[0] != expected[1])
    uniform = Loop(SCENARIO, compiled, [1, 2], "kinematic")
    loop.reset([1, 2])
    for each in (loop, uniform):
        each.step()
    wheels = (each.world.state.command.wheels[[2, 6]] for each in (loop, uniform))
    assert_array_equal(*wheels)


def test_a_message_is_felt_as_its_closeness_and_the_cosines_then_the_sines_of_its_bearings():
    beam = np.array([[[NEAR, 0.0, math.pi / 2], [3 * NEAR, math.pi / 6, -math.pi / 6]]], np.float32)
    felt = _message_features(beam, np)
    expected = [
        [0.5, 1.0, 0.0, 0.0, 1.0],
        [0.75, math.cos(math.pi / 6), math.cos(math.pi / 6), 0.5, -0.5],
    ]
    np.testing.assert_allclose(felt[0], expected, atol=1e-6)
