"""Faults: who is faulty is drawn apart from all else, and each kind does what it says."""

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.fault_record import BLIND, DEAD, DEAF, KINDS, MUTE, STALE, WORN
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from tests.worlds import check_each_is_itself

NEAR = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62}
"""Numbers of es1 under which robots soon find areas and meet."""


def loop(seeds=(3,), controller="ssgikf", scenario="es1", physics="kinematic", **numbers):
    changed = {name.replace("__", "."): value for name, value in numbers.items()}
    world = find_scenario(scenario, NEAR | changed)
    return Loop(world, find_controller(controller), seeds, physics)


def run(found, ticks):
    found.run(ticks)
    return found


def kinds(found, world=0):
    return found.world.faults["kinds"][world] != 0


def test_a_larger_share_adds_robots_to_those_of_a_smaller_one():
    few, many = (kinds(loop(faults__deaf__share=share))[:, DEAF] for share in (0.2, 0.5))
    assert (few <= many).all()
    assert few.sum() == 2


def test_who_is_faulty_depends_on_the_seed_and_not_on_the_other_faults():
    one = loop((3,), faults__mute__share=0.3)
    other = loop((4,), faults__mute__share=0.3)
    both = loop((3,), faults__mute__share=0.3, faults__liar__share=0.5)
    assert not np.array_equal(kinds(one), kinds(other))
    np.testing.assert_array_equal(kinds(one)[:, MUTE], kinds(both)[:, MUTE])


@pytest.mark.parametrize("physics", ["kinematic", "rigid"])
def test_a_dead_robot_moves_until_its_time_and_not_after(physics):
    found = loop(physics=physics, faults__dead__robots=(2,), faults__dead__at=3.0)
    start = found.world.state.pose[2].copy()
    run(found, 30)
    reached = found.world.state.pose[2].copy()
    assert np.hypot(*(reached - start)[:2]) > 0.01
    for _ in range(40):
        found.step()
        assert not found.world.state.wheels[2].any()
    assert found.world.state.is_faulty[2, DEAD]
    assert not found.world.state.readings.odometry[2].any()


@pytest.mark.parametrize(("talks", "hears"), [(True, True), (False, False)])
def test_a_dead_robot_talks_unless_its_radio_died_too(go, talks, hears):
    world = loop(faults__dead__share=1.0, faults__dead__talks=talks, max_range=0.5).world
    state = go(world, speaking=True)
    assert bool(state.heard.n.any()) is hears


@pytest.mark.parametrize(("kind", "hears"), [("deaf", False), ("mute", True)])
def test_a_deaf_robot_is_only_heard_and_a_mute_one_only_hears(go, kind, hears):
    sure = {"loss_near": 0.0, "loss_far": 0.0, "max_range": 0.5, "slots": 9}
    heard = go(loop(**{f"faults__{kind}__robots": (0,)}, **sure).world, speaking=True).heard
    assert (heard.n[0] > 0) == hears
    assert (heard.n[1:] > 0).all()
    assert any(0 in heard.sender[i, : heard.n[i]] for i in range(1, 10)) != hears


def test_a_blind_robot_reads_nothing_by_infrared():
    plain, blind = run(loop(), 50), run(loop(faults__blind__share=1.0), 50)
    assert plain.world.state.readings.proximity.any()
    assert not blind.world.state.readings.proximity.any()
    assert blind.world.faults["kinds"][..., BLIND].all()


def test_a_worn_robot_misreads_its_wheels_by_its_bias(go):
    worn = {"faults__worn__robots": (0,), "faults__worn__bias": 0.1, "wheel_noise": 0.0}
    state = go(loop(**worn).world, wheels=0.06)
    path, axle = 0.06 * 0.1, 0.053
    np.testing.assert_allclose(state.readings.odometry[:, 0], path, rtol=1e-5)
    assert abs(state.readings.odometry[0, 1]) == pytest.approx(0.2 * path / axle, rel=1e-5)
    np.testing.assert_allclose(state.readings.odometry[1:, 1], 0.0, atol=1e-9)


def test_a_worn_robot_has_noisier_encoders(go):
    numbers = {"faults__worn__share": 1.0, "faults__worn__bias": 0.0}
    plain = go(loop().world, wheels=0.06).readings.odometry[:, 0] - 0.006
    worn = loop(faults__worn__noise_factor=5.0, **numbers).world
    noisy = go(worn, wheels=0.06)
    np.testing.assert_allclose(noisy.readings.odometry[:, 0] - 0.006, 5.0 * plain, atol=1e-7)
    assert worn.faults["kinds"][..., WORN].all()


@pytest.mark.parametrize(
    ("conspire", "physics"), [("no", "rigid"), ("turn", "kinematic"), ("place", "kinematic")]
)
def test_a_world_in_a_block_is_the_world_alone(conspire, physics):
    shares = {"liar": 0.3, "stale": 0.2, "worn": 0.2, "dead": 0.1}
    faults = {f"faults.{name}.share": share for name, share in shares.items()}
    faults |= {"faults.liar.conspire": conspire, "faults.liar.probability": 0.5}
    world = find_scenario("es1", NEAR | faults | {"faults.dead.at": 5.0, "faults.stale.at": 15.0})
    check_each_is_itself(world, find_controller("ssgikf"), [5, 6, 7], physics, 100)


@pytest.mark.parametrize("name", ["liar", "stale"])
def test_a_learned_language_refuses_liars_by_name(name):
    sound, liars = (find_scenario("es1", {f"faults.{each}.share": 0.2}) for each in ("dead", name))
    policy, pattern = FORAGING.raw_control, rf"faults\.{name}: .*'policy' cannot be falsified"
    with pytest.raises(ConfigError, match=pattern):
        Loop(liars, policy, [0], "kinematic")
    found = Loop(sound, policy, [0], "kinematic")
    with pytest.raises(ConfigError, match=pattern):
        found.reset([1], scenarios=liars)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"faults.liar.robots": (0, 10)}, r"faults.liar.robots=\[0, 10\]: .* from 0 to 9"),
        ({"faults.liar.robots": (1, 1)}, r"must be different numbers"),
        ({"faults.dead.share": 0.2, "faults.dead.robots": (1,)}, r"faults\.dead.*not both"),
        ({"faults.liar.share": 1.2}, "faults.liar.share"),
        ({"faults.liar.conspire": "yes"}, "faults.liar.conspire"),
    ],
)
def test_nonsense_is_refused(numbers, message):
    with pytest.raises(ConfigError, match=message):
        find_scenario("es1", numbers)


def test_every_kind_has_a_part_of_its_name_that_cites_its_source():
    faults = find_scenario("es1").faults
    assert tuple(type(faults).model_fields) == KINDS
    for _, kind in faults:
        assert "Source: " in (type(kind).__doc__ or "")
        assert all(field.description for field in type(kind).model_fields.values())


def test_a_scene_marks_robots_whose_fault_is_in_effect():
    found = loop(faults__dead__robots=(1,), faults__stale__robots=(2,), faults__dead__at=1.0)
    np.testing.assert_array_equal(np.flatnonzero(found.scene().faulty), [2])
    run(found, 10)
    np.testing.assert_array_equal(np.flatnonzero(found.scene().faulty), [1, 2])
    assert found.world.state.is_faulty[2, STALE]
    assert loop().scene().faulty is None
