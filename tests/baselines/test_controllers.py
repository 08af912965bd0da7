"""The named controllers: their layers, their parameters, old names, and names put together."""

import math
import warnings
from typing import ClassVar

import numpy as np
import pytest

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.controllers import OLD_NAMES
from baselines.estimators.covariance_intersection import CovarianceIntersection
from baselines.estimators.dead_reckoning import DeadReckoning
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError, RenamedWarning, UnknownNameError
from swarm_forage_env.parameters import Parameters, Share
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario

STRATEGIES = {
    #         weighting, speaks, double: TR 6.1
    "nc": (SGIKF, False, False),
    "ssgikf": (SGIKF, True, False),
    "dsgikf": (SGIKF, True, True),
    "ssgiff": (SGIFF, True, False),
    "dsgiff": (SGIFF, True, True),
}


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_strategy_of_the_paper_is_found_by_name(name):
    controller = CONTROLLERS[name]
    weighting, speaks, double = STRATEGIES[name]
    assert isinstance(controller.weighting, weighting)
    assert controller.estimator.speaks == speaks
    assert not speaks or controller.estimator.double == double


@pytest.mark.parametrize(("old", "new"), OLD_NAMES.items())
def test_an_old_name_still_works_and_tells_the_new_one_once(old, new):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("default")
        for _ in range(2):
            found = find_controller(f"{old}:beta=0.003")
    (warning,) = told
    assert warning.category is RenamedWarning
    assert f"controller '{old}' is now '{new}'" in str(warning.message)
    assert found == CONTROLLERS[new].with_parameters({"beta": 0.003})
    assert old in CONTROLLERS
    assert old not in set(CONTROLLERS)


def test_three_layers_by_their_names_make_a_controller_that_takes_parameters():
    found = find_controller("social_odometry + sgiff + subsumption:beta=0.5,double=true")
    assert found.name == "social_odometry+sgiff+subsumption"
    changed = CONTROLLERS["ssgiff"].with_parameters({"beta": 0.5, "double": True})
    assert found.parameters == changed.parameters
    assert find_controller(found.name).parameters == CONTROLLERS["ssgiff"].parameters


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("social_odmetry+sgiff+subsumption", "no estimator named 'social_odmetry', did you mean"),
        ("social_odometry+sgif+subsumption", "no weighting rule named 'sgif', did you mean"),
        ("social_odometry+sgiff+subsumtion", "no motion named 'subsumtion', did you mean"),
        ("ssgiff:bta=1", "no parameter of ssgiff named 'bta', did you mean 'weighting.beta'?"),
        ("nc:beta=1", "no parameter of nc named 'beta'"),
        ("nc:motion.hld=1", "no parameter of nc named 'motion.hld', did you mean 'motion.hold'?"),
        ("nc:estimator=dead_reckonning", "no estimator named 'dead_reckonning', did you mean"),
        (
            "boids-goal:estimator=social_odometry,setting=authors",
            "no parameter of boids-goal named 'setting'",
        ),
    ],
)
def test_an_unknown_layer_or_parameter_is_refused_with_the_nearest(name, message):
    with pytest.raises(UnknownNameError) as error:
        find_controller(name)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize("name", ["social_odometry+sgiff", "a+b+c+d", "+"])
def test_a_composition_of_another_number_of_layers_is_refused_with_an_example(name):
    with pytest.raises(ConfigError, match=r"estimator\+weighting\+motion, as in"):
        find_controller(name)


def test_parameters_are_changed_by_path_or_last_word_and_the_original_stays():
    before = CONTROLLERS["ssgiff"].parameters
    changed = CONTROLLERS["ssgiff"].with_parameters(
        {"weighting.beta": "0.5", "refractory": 3, "avoidance": "literal"}
    )
    assert changed.parameters["weighting.beta"] == 0.5
    assert changed.parameters["estimator.refractory"] == 3.0
    assert changed.parameters["motion.avoidance"] == "literal"
    assert CONTROLLERS["ssgiff"].parameters == before


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"beta": "steep"}, "beta='steep': input should be a valid number"),
        ({"beta": -1.0}, "beta=-1.0: input should be greater than or equal to 0"),
        ({"beta": math.nan}, "beta=nan: input should be a finite number"),
        ({"beta": math.inf}, "beta=inf: input should be a finite number"),
        ({"beta": math.nextafter(1e6, math.inf)}, "beta=1000000.0"),
        ({"lost_within": 0.0}, "lost_within=0.0: input should be greater than 0"),
        ({"double": "both"}, "double='both': input should be a valid boolean"),
        ({"avoidance": "leteral"}, "avoidance='leteral': input should be 'tangential' or"),
        ({"gap": 0.2}, "gap=0.2: input should be less than or equal to 0.05"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_what_would(values, message):
    with pytest.raises(ConfigError) as error:
        CONTROLLERS["ssgiff"].with_parameters(values)
    assert str(error.value).startswith(message)


BOIDS = CONTROLLERS["boids-adaptive"]


@pytest.mark.parametrize("text", ["estimator=dead_reckoning,setting=authors",
                                  "setting=authors,estimator=dead_reckoning"])  # fmt: skip
def test_the_parameters_of_a_chosen_layer_can_be_named_in_any_order_and_are_kept(text):
    chosen = find_controller(f"boids-adaptive:{text}")
    assert chosen.estimator == DeadReckoning(setting="authors")
    assert (chosen.weighting, chosen.motion) == (BOIDS.weighting, BOIDS.motion)
    assert not chosen.talks
    other = chosen.with_parameters({"estimator": "covariance_intersection"})
    assert other.estimator == CovarianceIntersection(setting="authors")
    assert other.talks


@pytest.mark.parametrize("name", ["boids-goal", "boids-static", "boids-adaptive"])
def test_boids_run_on_both_tasks_and_subsumption_forages(name):
    waypoints, foraging = find_scenario("waypoints-05"), find_scenario("es1")
    assert CONTROLLERS[name].supports(waypoints)
    assert CONTROLLERS[name].supports(foraging)
    assert CONTROLLERS["subsumption"].supports(foraging)
    with pytest.raises(ConfigError, match="its motion is not made for the task waypoints"):
        CONTROLLERS["subsumption"].check_supports(waypoints)
    social = CONTROLLERS[name].with_parameters({"estimator": "social_odometry"})
    with pytest.raises(ConfigError, match="its estimator is not made for the task waypoints"):
        social.check_supports(waypoints)


class MyRule(Parameters):
    """A rule from outside: always the same share."""

    heard_p_share: ClassVar[float] = 1.0
    share: Share = 0.25

    def __call__(self, exchange):
        return np.full(exchange.own_p.shape, self.share, np.float32)


def test_evaluate_runs_a_rule_from_outside(monkeypatch, command):
    monkeypatch.setattr(WEIGHTING_RULES, "_parts", dict(WEIGHTING_RULES._parts))
    WEIGHTING_RULES.register("my_rule")(MyRule)
    arguments = "--episodes=2", "--set=task.duration=120", "--physics=kinematic", "--workers=1"
    texts = "social_odometry+my_rule+subsumption", "social_odometry+my_rule+subsumption:share=0.9"
    status, told, _ = command("evaluate", "es1", *texts, *arguments, "--format=csv")
    lines = told.splitlines()
    assert status == 0
    assert [line.split(",")[1] for line in lines[1:]] == [texts[0]] * 2 + [texts[1]] * 2
    one, other = (line.split(",")[6:12] for line in (lines[1], lines[3]))
    assert one != other, "the rule is asked, and its parameter counts"
