"""Environments whose robots have different controllers, by name, by number or in a list."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env import ConfigError, UnknownNameError, find_scenario
from swarm_forage_env.controllers import find_controllers
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.swarm_forage_v0 import parallel_env

ES1 = find_scenario("es1")


def names(controller, scenario=ES1):
    """What drives each robot of a mixed swarm."""
    return [each.name for each in find_controllers(controller, scenario).members]


def test_a_list_of_equal_controllers_is_the_uniform_swarm(busy, sampler):
    one = parallel_env(busy, controller="ssgiff:beta=0.02", physics="kinematic")
    many = parallel_env(busy, controller=["ssgiff:beta=0.02"] * 10, physics="kinematic")
    draw = sampler(one, 0)
    first, other = one.reset(seed=3)[0], many.reset(seed=3)[0]
    for _ in range(100):
        for agent in one.possible_agents:
            assert_array_equal(first[agent], other[agent])
        actions = draw()
        first, other = one.step(actions)[0], many.step(actions)[0]


def test_robots_are_named_or_numbered_and_the_rest_has_the_default_or_what_the_star_says():
    some = {"epuck_0": "ssgiff", 3: "dsgiff"}
    assert names(some) == ["ssgiff", *["ssgikf"] * 2, "dsgiff", *["ssgikf"] * 6]
    assert names({"*": "nc", **some}) == ["ssgiff", *["nc"] * 2, "dsgiff", *["nc"] * 6]
    assert find_controllers({}, ES1) is CONTROLLERS["ssgikf"]
    assert find_controllers(None, ES1) is CONTROLLERS["ssgikf"]
    assert find_controllers({"*": CONTROLLERS["nc"]}, ES1) is CONTROLLERS["nc"]
    waypoints = find_scenario("waypoints-05")
    assert names({"create_4": "boids-goal"}, waypoints) == ["boids-adaptive"] * 4 + ["boids-goal"]


def test_a_mixed_swarm_tells_how_many_robots_have_each_controller():
    found = find_controllers({"epuck_0": "ssgiff", "*": "dsgiff-penalised"}, ES1)
    assert found.name == "1 ssgiff, 9 dsgiff-penalised"
    assert found.message_path == CONTROLLERS["dsgiff-penalised"].message_path > 0.0
    assert found.talks
    assert not find_controllers({"*": "nc", 0: "nc:pause=1"}, ES1).talks
    changed = found.with_parameters({"beta": 0.5})
    assert {each.weighting.beta for each in changed.members} == {0.5}


@pytest.mark.parametrize("learn", ["weighting", "motion", "both"])
@pytest.mark.parametrize("scenario", ["es1", "waypoints-05"])
def test_what_an_environment_of_a_mixed_swarm_shows_is_in_its_spaces(learn, scenario, sampler):
    mixture = {0: "boids-goal"} if scenario == "waypoints-05" else {0: "sikf", 1: "dsgiff"}
    env = parallel_env(scenario, learn=learn, controller=mixture, physics="kinematic")
    env.reset(seed=1)
    draw = sampler(env, 0)
    for _ in range(100):
        observations, _, _, _, infos = env.step(draw())
        for agent, observed in observations.items():
            assert env.observation_space(agent).contains(observed)
        assert env.state_space.contains(env.state())
    assert set(infos) == set(observations)


def test_learners_steer_every_robot_of_a_mixed_swarm(busy, constant):
    env = parallel_env(busy, controller={0: "sikf", 1: "dsgiff"}, physics="kinematic")
    env.reset(seed=1)
    for _ in range(3):
        env.step(constant(env, 0.5, -0.25))
        assert np.all(env.world.robots["command"]["wheels"] == np.float32([0.5, -0.25]))


@pytest.mark.parametrize(
    ("controller", "says"),
    [
        (["ssgikf"] * 9, "9 controllers given for the 10 robots of 'es1': must be one for each"),
        ([], "0 controllers given for the 10 robots"),
        ({"epuck_0": "oracle-weighting"}, "no controller named 'oracle-weighting'|ground truth"),
        ({"epuck_0": "nc", 0: "nc"}, "robot 0 is given twice, by name and by number"),
        ({"epuck_0": None}, "controller=None: must be a name or a controller"),
        ([["nc"]] * 10, "must be a name or a controller"),
        ({0: "ssgiff:beta"}, "'beta' must be parameter=value"),
    ],
)
def test_a_mixture_that_cannot_be_used_is_refused(controller, says):
    with pytest.raises((ConfigError, UnknownNameError), match=says):
        parallel_env("es1", controller=controller)


@pytest.mark.parametrize(
    ("robot", "says"),
    [
        ("epuk_3", "no robot named 'epuk_3', did you mean 'epuck_3'"),
        ("epuck_10", "no robot named 'epuck_10', did you mean 'epuck_1'"),
        (10, "no robot named '10'"),
        (-1, "no robot named '-1'"),
        (True, "no robot named 'True'"),
    ],
)
def test_a_robot_that_there_is_not_is_answered_with_the_nearest(robot, says):
    with pytest.raises(UnknownNameError, match=says):
        parallel_env("es1", controller={robot: "nc"})


def test_an_oracle_is_refused_in_any_company():
    from baselines.oracles.controllers import NAMED

    for oracle in NAMED:
        with pytest.raises(ConfigError, match="knows the ground truth"):
            parallel_env("es1", controller={2: oracle})
        with pytest.raises(ConfigError, match="knows the ground truth"):
            parallel_env("es1", controller=[oracle] * 10)


def test_controllers_of_another_task_are_refused_in_any_company():
    with pytest.raises(ConfigError, match="'nc' does not run on 'waypoints-05'"):
        parallel_env("waypoints-05", controller={0: "nc"})


def test_robots_that_correct_each_other_need_one_estimator():
    other = "boids-adaptive:estimator=covariance_intersection"
    with pytest.raises(ConfigError, match="all need the same estimator"):
        parallel_env("waypoints-05", controller={0: other})
    authors = "boids-adaptive:setting=authors,estimator=covariance_intersection"
    with pytest.raises(ConfigError, match="all need the same estimator"):
        parallel_env("waypoints-05", controller={"*": other, 0: authors})


def test_a_policy_of_everything_takes_no_mixture():
    with pytest.raises(ConfigError, match="none runs where learn='everything'"):
        parallel_env("es1", learn="everything", controller={0: "nc"})
