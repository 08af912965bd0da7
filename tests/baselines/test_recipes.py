"""The named baselines and their parameters."""

import pytest
from baselines.recipes import RECIPES

from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.errors import ConfigError, UnknownNameError
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
    recipe = CONTROLLERS[name]
    weighting, speaks, double = STRATEGIES[name]
    assert recipe.name == name
    assert isinstance(recipe.weighting, weighting)
    assert recipe.estimator.speaks == speaks
    assert not speaks or recipe.estimator.double == double


def test_every_recipe_is_registered_once_under_its_name():
    names = [recipe.name for recipe in RECIPES]
    assert len(set(names)) == len(names)
    assert all(CONTROLLERS[recipe.name] is recipe for recipe in RECIPES)


def test_strategies_differ_in_what_their_names_say_and_in_nothing_else():
    for single, double in (("ssgikf", "dsgikf"), ("ssgiff", "dsgiff")):
        changed = CONTROLLERS[single].with_parameters({"double": True})
        assert changed.parameters == CONTROLLERS[double].parameters
    assert CONTROLLERS["ssgikf"].estimator == CONTROLLERS["ssgiff"].estimator
    assert len({recipe.motion for recipe in RECIPES if "boids" not in recipe.name}) == 1


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
