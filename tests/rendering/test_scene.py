"""A scene holds what is true, what is believed and who was heard, in the world frame."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.loop import Loop
from swarm_forage_env.scene import EXPLORING, LOST, TALKING, TO_THE_NEST, TO_THE_PREY
from tests.beliefs import localisation_error


@pytest.fixture
def loop(busy):
    """Two worlds of ten robots after two and a half minutes."""
    found = Loop(busy, find_controller("ssgikf"), [1, 2])
    found.run(1500)
    return found


def scenes(loop):
    return [loop.scene(which) for which in range(2)]


def test_a_scene_is_the_truth_about_its_own_world(loop):
    state = loop.world.state
    for which, scene in enumerate(scenes(loop)):
        rows = slice(10 * which, 10 * which + 10)
        assert scene.time == pytest.approx(150.0)
        assert_array_equal(scene.pose, state.pose[rows])
        assert_array_equal(scene.round_trips, state.round_trips[rows])
        assert scene.total == state.round_trips[rows].sum()
        assert scene.on_path == state.known[rows].all(axis=1).mean()
    assert len({scene.total for scene in scenes(loop)}) == 2


def test_beliefs_are_as_far_off_as_the_localisation_error_says(loop):
    beliefs, world = loop.situation, loop.world
    error = localisation_error(loop)
    known = np.concatenate([scene.known for scene in scenes(loop)])
    believed = np.concatenate([scene.believed for scene in scenes(loop)])
    off = np.hypot(*(believed - world.areas).transpose(2, 0, 1))
    assert_array_equal(known, beliefs.known)
    assert 0 < known.sum() < known.size
    assert off[known] == pytest.approx(error[known], abs=1e-6)
    assert not believed[~known].any()
    assert_array_equal(np.concatenate([scene.p for scene in scenes(loop)]), beliefs.p)


def test_messages_are_pairs_of_sender_and_receiver_of_one_world(loop):
    heard = loop.world.robots["heard"]
    while not heard["n"].any(axis=1).all():
        loop.step()
    for which, scene in enumerate(scenes(loop)):
        n_slots = heard["sender"].shape[2]
        receivers, slots = np.nonzero(np.arange(n_slots) < heard["n"][which][:, None])
        senders = heard["sender"][which][receivers, slots]
        pairs = set(zip(senders.tolist(), receivers.tolist(), strict=True))
        assert {tuple(pair) for pair in scene.messages.tolist()} == pairs
        assert len(scene.messages) == len(pairs)


def test_a_robot_is_doing_what_it_believes_to_do(loop):
    robots, situation = loop.world.robots[0], loop.controller.minds["estimator"]["situation"][0]
    situation["goal"], situation["is_talking"] = (0, 0, 1), False
    situation["goal"][:3], situation["is_talking"][2] = np.eye(3)[[0, 1, 1]], True
    robots["lost_events"], robots["known"] = 0, 0
    robots["lost_events"][[3, 4, 0]] = 1
    robots["known"][4, 1] = 1
    scene = loop.scene()
    assert scene.activity[:5].tolist() == [TO_THE_NEST, TO_THE_PREY, TALKING, LOST, EXPLORING]


def test_without_beliefs_a_robot_goes_where_the_task_sends_it(busy):
    loop = Loop(busy, FORAGING.raw_control, [1])
    loop.world.robots["leg"][0, :3] = 0, 1, 2
    scene = loop.scene()
    assert scene.activity[:3].tolist() == [EXPLORING, TO_THE_PREY, TO_THE_NEST]
    assert not scene.known.any()
    assert not scene.believed.any()


def test_a_scene_stays_as_it_is(loop):
    scene = scenes(loop)[0]
    pose, known, trips = scene.pose.copy(), scene.known.copy(), scene.round_trips.copy()
    loop.run(200)
    loop.reset([5, 6])
    assert_array_equal(scene.pose, pose)
    assert_array_equal(scene.known, known)
    assert_array_equal(scene.round_trips, trips)
