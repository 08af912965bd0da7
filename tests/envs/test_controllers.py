"""Controllers by name, with parameters: of all robots, or of each by name, number or in a list."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.oracles.controllers import NAMED as ORACLES
from swarm_forage_env import ConfigError, UnknownNameError, find_scenario
from swarm_forage_env.controllers import find_controllers, parse_controller
from swarm_forage_env.registry import CONTROLLERS
from tests.commands import parallel_env

ES1 = find_scenario("es1")


def names(controller, scenario=ES1):
    """What drives each robot of a mixed swarm."""
    return [each.name for each in find_controllers(controller, scenario).members]


@pytest.mark.parametrize("text", ["nc:", "nc:beta", "nc:=1", "nc:beta=", "nc:a=1,", "nc:a=1,a=2"])
def test_a_text_of_another_form_is_refused(text):
    with pytest.raises(ConfigError, match="controller='nc:"):
        parse_controller(text)


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


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (["ssgikf"] * 9, "9 controllers given for the 10 robots of 'es1': must be one for each"),
        ([], "0 controllers given for the 10 robots"),
        ({"epuck_0": "oracle-weighting"}, "no controller named 'oracle-weighting'|ground truth"),
        *(([each] * 10, "knows the ground truth") for each in ORACLES),
        ({"epuck_0": "nc", 0: "nc"}, "robot 0 is given twice, by name and by number"),
        ({"epuck_0": None}, "controller=None: must be a name or a controller"),
        ([["nc"]] * 10, "must be a name or a controller"),
        ({10: "nc"}, "no robot named '10'"),
        ({-1: "nc"}, "no robot named '-1'"),
        ({True: "nc"}, "no robot named 'True'"),
        ({"epuk_3": "nc"}, "no robot named 'epuk_3', did you mean 'epuck_3'"),
        ({"epuck_10": "nc"}, "no robot named 'epuck_10', did you mean 'epuck_0' or 'epuck_1'"),
    ],
)
def test_a_mixture_that_cannot_be_used_is_refused(controller, message):
    with pytest.raises((ConfigError, UnknownNameError), match=message):
        parallel_env("es1", controller=controller)


CI = "boids-adaptive:estimator=covariance_intersection"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"controller": {0: "nc"}}, "'nc' does not run on 'waypoints-05'"),
        ({"controller": {0: CI}}, "all need the same estimator"),
        ({"controller": {"*": CI, 0: f"{CI},setting=authors"}}, "all need the same estimator"),
        ({"learn": "everything", "learners": 2}, "all need the same estimator"),
    ],
)
def test_robots_that_correct_each_other_need_one_estimator_of_their_task(options, message):
    with pytest.raises(ConfigError, match=message):
        parallel_env("waypoints-05", **options)


def test_where_all_robots_learn_everything_there_is_no_mixture():
    for learners, controller in ((None, "dsgiff"), (10, {0: "nc"})):
        with pytest.raises(ConfigError, match="no robot to run if learn='everything'"):
            parallel_env("es1", learn="everything", learners=learners, controller=controller)


def test_some_robots_learn_a_correction_and_the_others_go_by_their_motion(busy):
    options = {"residual": True, "decision_period": 1, "physics": "kinematic"}
    still, left = np.zeros(2, np.float32), np.array([-0.5, 0.5], np.float32)
    others = {f"epuck_{k}": still for k in range(10)}
    poses = []
    for learners, actions in (
        ([3], {"epuck_3": left}),
        (None, {**others, "epuck_3": left}),
        (None, others),
    ):
        env = parallel_env(busy, learners=learners, **options)
        env.reset(seed=3)
        for _ in range(200):
            env.step(actions)
        poses.append(env.world.robots["pose"].copy())
    some, everybody, plain = poses
    assert_array_equal(some, everybody)
    assert not np.array_equal(some, plain)
