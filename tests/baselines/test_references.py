"""References know the truth, through a door that nobody else can use."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from baselines.evaluation.experiment_config import ExperimentConfig, find_recipe
from baselines.references.oracle import moved
from baselines.references.recipes import RECIPES
from baselines.references.reference import Reference
from swarm_forage_env import ConfigError, parallel_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.ground_truth import GroundTruth, is_reference
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.scenarios import find_scenario

NAMES = [recipe.name for recipe in RECIPES]
BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.05}


def run(name, ticks, seeds=(0,), physics="kinematic", **overrides):
    scenario = find_scenario("es1", BUSY | overrides)
    loop = ControlLoop(scenario, find_recipe(name), seeds, physics)
    for _ in range(ticks):
        loop.step()
    return loop


def within_reach_of(thing, seen):
    """Every object that a controller holds, and what these hold."""
    if id(thing) in seen or isinstance(thing, (str, bytes, int, float, type)):
        return
    seen[id(thing)] = thing
    names = [*getattr(thing, "__dict__", {}), *getattr(type(thing), "__slots__", ())]
    for name in names:
        within_reach_of(getattr(thing, name, None), seen)
    if isinstance(thing, (list, tuple)):
        for each in thing:
            within_reach_of(each, seen)


FORAGERS = [name for name in CONTROLLERS if CONTROLLERS[name].runs_on(Scenario())]


@pytest.mark.parametrize("name", [*FORAGERS, *REFERENCES])
def test_the_truth_is_within_reach_of_references_only(name):
    loop, seen = run(name, 1), {}
    within_reach_of(loop.controller, seen)
    truth = [each for each in seen.values() if isinstance(each, GroundTruth)]
    shared = [
        each
        for each in seen.values()
        if isinstance(each, np.ndarray) and np.shares_memory(each, loop.world.state.pose)
    ]
    assert bool(truth) == bool(shared) == (name in NAMES)


def test_the_two_registries_share_no_name():
    assert set(NAMES) == set(REFERENCES)
    assert not set(REFERENCES) & set(CONTROLLERS)
    assert not any(is_reference(CONTROLLERS[name]) for name in CONTROLLERS)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("learn", ["weighting", "motion", "both", "everything"])
def test_no_environment_takes_a_reference_by_name_or_as_an_object(name, learn):
    for controller in (name, REFERENCES[name]):
        with pytest.raises(ConfigError, match=f"controller '{name}' is a reference that knows"):
            parallel_env("es1", learn=learn, controller=controller)


def test_a_reference_is_not_suggested_where_it_is_refused():
    with pytest.raises(UnknownNameError) as error:
        find_controller("no-eror")
    assert "no-error" not in str(error.value)
    with pytest.raises(UnknownNameError, match="did you mean 'no-error'"):
        find_recipe("no-eror")


def test_a_reference_is_built_by_the_control_loop_only():
    with pytest.raises(ConfigError, match="needs the ground truth"):
        REFERENCES["no-error"].build(find_scenario("es1"), [0])


def test_the_truth_cannot_be_changed():
    truth = run("no-error", 1).controller.estimator._truth
    for array in (truth.pose, truth.areas):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("name", NAMES)
def test_a_reference_takes_parameters_and_stays_a_reference(name):
    recipe = find_recipe(f"{name}:deaf_when_lost=7")
    assert isinstance(recipe, Reference)
    assert recipe.parameters["estimator.deaf_when_lost"] == 7.0
    configuration = ExperimentConfig(name, find_scenario("es1"), recipe)
    assert configuration.parameters == '{"estimator.deaf_when_lost": 7.0}'
    assert configuration.key != ExperimentConfig(name, find_scenario("es1"), find_recipe(name)).key


@pytest.mark.parametrize("name", NAMES)
def test_a_world_in_a_block_is_the_world_alone_also_after_a_reset(name):
    alone, block = run(name, 300, [5]), run(name, 40, [7, 8])
    block.reset([3, 5])
    for _ in range(300):
        block.step()
    assert_array_equal(alone.world.state.pose, block.world.state.pose[10:])
    believed = alone.controller.estimator.beliefs, block.controller.estimator.beliefs
    assert_array_equal(believed[0].location, believed[1].location[10:])


def test_without_error_the_believed_pose_is_the_true_one_also_when_pushed():
    loop = run("no-error", 400, physics="rigid")
    estimator = loop.controller.estimator
    assert_array_equal(estimator.beliefs.pose, loop.world.state.pose)


def test_without_error_p_is_the_true_path():
    loop = run("no-error", 0)
    before, p = loop.world.state.pose.copy(), loop.controller.estimator.beliefs.p.copy()
    loop.step()
    after = loop.world.state.pose
    way = np.hypot(*(after - before)[:, :2].T)
    turn = np.abs((after - before)[:, 2] + np.pi) % (2 * np.pi) - np.pi
    expected = way + 0.5 * 0.053 * np.abs(turn)
    assert_allclose(loop.controller.estimator.beliefs.p[:, 0] - p[:, 0], expected, atol=1e-12)


def test_the_oracle_takes_the_estimate_that_is_nearer_the_area():
    loop = run("oracle-weighting", 0)
    e, b = loop.controller.estimator.encounter, loop.controller.estimator.beliefs
    truth = loop.controller.weighting._truth
    nest = moved(np.tile(truth.areas, (10, 1, 1)), truth.pose, b.pose)
    b.location[:] = nest + np.array([0.2, 0.0])
    b.heard_weight[:], e.heard_known[:], e.own_known[:] = 2.0, True, True
    off = np.linspace(0.0, 0.38, 10)
    b.heard_sum[:] = 2.0 * (nest + [[0.0, 1.0]] * off[:, None, None])
    e.heard_known[0, 0] = False
    g = loop.controller.weighting(e)
    assert_array_equal(g[:, 1], off < 0.2)
    assert g[0, 0] == 0.0
    assert set(np.unique(g)) == {0.0, 1.0}


def test_global_communication_gives_everyone_the_mean_of_those_who_know():
    loop = run("global", 0, **{"radio.exchange_time": 0.1})
    estimator, pose = loop.controller.estimator, loop.world.state.pose
    b = estimator.beliefs
    places = np.array([[0.3, 0.1], [0.5, -0.3]])
    for robot, place in enumerate(places):
        b.location[robot, 0] = moved(
            np.tile(place, (1, 2, 1)), pose[robot : robot + 1], b.pose[robot : robot + 1]
        )[0, 0]
        b.known[robot, 0], b.p[robot, 0] = True, 1.0 + robot
    b.p[2:] = 9.0
    b.deaf[5] = 3
    estimator._talk(loop.world.feedback.heard)
    hearing = np.arange(10) != 5
    assert_array_equal(b.known[:, 0], hearing)
    assert not b.known[:, 1].any()
    world = moved(b.location, b.pose, pose)[hearing, 0]
    assert_allclose(world, np.tile(places.mean(axis=0), (9, 1)), atol=1e-12)
    assert_allclose(b.p[hearing, 0], 1.5)
    assert b.p[5, 0] == 9.0


def test_global_communication_averages_once_per_exchange_time():
    loop = run("global", 0, **{"radio.exchange_time": 0.5})
    estimator = loop.controller.estimator
    estimator.beliefs.known[0, 0] = True
    knowing = []
    for _ in range(10):
        estimator._talk(loop.world.feedback.heard)
        knowing.append(int(estimator.beliefs.known[:, 0].sum()))
    assert knowing.index(10) <= 4
