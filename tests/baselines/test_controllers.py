"""The named baselines and their parameters."""

import pytest

from baselines.controllers import NAMED, OLD_NAMES
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError, RenamedWarning, UnknownNameError
from swarm_forage_env.registry import CONTROLLERS

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
    assert controller.name == name
    assert isinstance(controller.weighting, weighting)
    assert controller.estimator.speaks == speaks
    assert not speaks or controller.estimator.double == double


def test_every_controller_is_registered_once_under_its_name():
    names = [controller.name for controller in NAMED]
    assert len(set(names)) == len(names)
    assert all(CONTROLLERS[controller.name] is controller for controller in NAMED)


def test_strategies_differ_in_what_their_names_say_and_in_nothing_else():
    for single, double in (("ssgikf", "dsgikf"), ("ssgiff", "dsgiff")):
        changed = CONTROLLERS[single].with_parameters({"double": True})
        assert changed.parameters == CONTROLLERS[double].parameters
    assert CONTROLLERS["ssgikf"].estimator == CONTROLLERS["ssgiff"].estimator
    assert len({each.motion for each in NAMED if "boids" not in each.name}) == 1


@pytest.mark.parametrize(("old", "new"), OLD_NAMES.items())
def test_an_old_name_still_works_and_tells_the_new_one(old, new):
    with pytest.warns(RenamedWarning, match=f"controller '{old}' is now '{new}'"):
        found = find_controller(f"{old}:beta=0.003")
    assert found == CONTROLLERS[new].with_parameters({"beta": 0.003})
    assert old in CONTROLLERS
    assert old not in set(CONTROLLERS)


def test_three_layers_by_their_names_make_a_controller_that_takes_parameters():
    found = find_controller("social_odometry + sgiff + subsumption:beta=0.5,double=true")
    assert found.name == "social_odometry+sgiff+subsumption"
    assert found.estimator == SocialOdometryParameters(double=True)
    assert found.weighting == SGIFF(beta=0.5)
    assert found.motion == SubsumptionParameters()
    assert find_controller(found.name).parameters == CONTROLLERS["ssgiff"].parameters


@pytest.mark.parametrize("name", ["social_odometry+sgiff", "a+b+c+d", "+"])
def test_a_composition_of_another_number_of_layers_is_refused_with_an_example(name):
    with pytest.raises(ConfigError, match=r"estimator\+weighting\+motion, as in"):
        find_controller(name)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("social_odmetry+sgiff+subsumption", "no estimator named 'social_odmetry', did you mean"),
        ("social_odometry+sgif+subsumption", "no weighting rule named 'sgif', did you mean"),
        ("social_odometry+sgiff+subsumtion", "no motion named 'subsumtion', did you mean"),
    ],
)
def test_a_misspelt_layer_of_a_composition_is_refused_with_the_nearest(name, message):
    with pytest.raises(UnknownNameError) as error:
        find_controller(name)
    assert str(error.value).startswith(message)


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
        ({"beta": float("nan")}, "beta=nan: input should be a finite number"),
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


@pytest.mark.parametrize(
    ("name", "typo", "message"),
    [
        ("ssgiff", "bta", "no parameter of ssgiff named 'bta', did you mean 'weighting.beta'?"),
        ("nc", "beta", "no parameter of nc named 'beta'"),
        ("nc", "motion.hld", "no parameter of nc named 'motion.hld', did you mean 'motion.hold'?"),
    ],
)
def test_an_unknown_parameter_is_refused_with_the_nearest(name, typo, message):
    with pytest.raises(UnknownNameError) as error:
        CONTROLLERS[name].with_parameters({typo: 1.0})
    assert str(error.value).startswith(message)
