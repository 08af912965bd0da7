"""Oracles know the truth, and nobody else does."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from baselines.oracles.controllers import NAMED
from baselines.oracles.oracle import OracleWeighting, moved
from swarm_forage_env import ConfigError, parallel_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import is_privileged
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario

NAMES = [controller.name for controller in NAMED]
BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.05}


def start(name, seeds=(0,), physics="kinematic", **overrides):
    scenario = find_scenario("es1", BUSY | overrides)
    return Loop(scenario, find_controller(name, references=True), seeds, physics)


def beliefs(loop):
    return rows(loop.controller.minds["estimator"]["belief"])


def run_deceived(name, ticks, far):
    """Robots that are wrong about their places by that far, and unsure enough to listen."""
    loop = start(name, **{"radio.max_range": 0.5, "radio.exchange_time": 0.1})
    controller, pose, b = loop.controller, loop.world.robots["pose"], beliefs(loop)
    rng = np.random.default_rng(1)
    b.location[:], b.known[:], b.p[:] = rng.normal(size=b.location.shape), True, 6.0
    away = far * rng.normal(size=pose.shape)
    for _ in range(ticks):
        true = pose.copy()
        pose += away
        controller.call_rules()
        loop.run_stages("decide")
        pose[:] = true
        loop.world.tick(0, 1)
        true = pose.copy()
        pose += away
        loop.run_stages("observe")
        pose[:] = true
    return loop


FORAGERS = [name for name in CONTROLLERS if CONTROLLERS[name].supports(Scenario())]


@pytest.mark.parametrize("name", [*FORAGERS, *REFERENCES])
def test_only_a_reference_acts_on_the_truth(name):
    told, deceived = (run_deceived(name, 160, far) for far in (0.0, 1.0))
    same = np.array_equal(told.world.robots["pose"], deceived.world.robots["pose"])
    assert same == (name not in NAMES)


def test_the_two_registries_share_no_name():
    assert set(NAMES) == set(REFERENCES)
    assert not set(REFERENCES) & set(CONTROLLERS)
    assert not any(is_privileged(CONTROLLERS[name]) for name in CONTROLLERS)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("learn", ["weighting", "motion", "both", "everything"])
def test_no_environment_takes_a_reference_by_name_or_as_an_object(name, learn):
    changed = find_controller(f"{name}:deaf_when_lost=7", references=True)
    assert changed.parameters["estimator.deaf_when_lost"] == 7.0
    for controller in (name, REFERENCES[name], changed):
        with pytest.raises(ConfigError, match=f"controller '{name}' is a reference that knows"):
            parallel_env("es1", learn=learn, controller=controller)


PLACES = np.array([[0.3, 0.1], [0.5, -0.3]])


def test_global_communication_gives_everyone_but_the_deaf_the_mean_of_those_who_know():
    loop = start("global:through_radio=false")
    b, pose = beliefs(loop), loop.world.state.pose
    b.known[:] = 0
    for robot, place in enumerate(PLACES):
        b.location[robot, 0] = moved(
            np.tile(place, (1, 2, 1)), pose[robot : robot + 1], b.pose[robot : robot + 1]
        )[0, 0]
        b.known[robot, 0], b.p[robot, 0] = True, 1.0 + robot
    b.p[2:] = 9.0
    b.ignore_ticks[5] = 1000
    hearing = np.arange(10) != 5
    while b.known[hearing, 0].sum() < 9:
        loop.run_stages("observe")
    places = moved(b.location, b.pose, pose)[hearing, 0]
    assert_array_equal(b.known[:, 0], hearing)
    assert not b.known[:, 1].any()
    assert_allclose(places, np.tile(PLACES.mean(axis=0), (9, 1)), atol=1e-6)
    assert_allclose(b.p[hearing, 0], 1.5)
    assert b.p[5, 0] == 9.0


def test_the_oracle_takes_the_estimate_that_is_nearer_the_area():
    loop = start("oracle-weighting")
    b, e = beliefs(loop), rows(loop.controller.minds["estimator"]["exchange"])
    nest = moved(np.tile(loop.world.areas, (10, 1, 1)), loop.world.state.pose, b.pose)
    b.location[:] = nest + np.array([0.2, 0.0])
    b.heard_weight[:] = 2.0
    e.is_valid[:], e.heard_known[:], e.own_known[:] = True, True, True
    off = np.linspace(0.0, 0.38, 10)
    b.heard_sum[:] = 2.0 * (nest + [[0.0, 1.0]] * off[:, None, None])
    e.heard_known[0, 0] = False
    g = OracleWeighting().start_knowing(loop.controller, loop.world)(loop.exchange)
    assert_array_equal(g[:, 1], off < 0.2)
    assert g[0, 0] == 0.0
    assert set(np.unique(g)) == {0.0, 1.0}
