"""Controllers by name, with parameters."""

import pytest

from swarm_forage_env import ConfigError, UnknownNameError
from swarm_forage_env.controllers import find_controller, parse_controller


def test_parameters_follow_the_name():
    recipe = find_controller("ssgiff:beta=0.02, refractory = 5,avoidance=literal")
    assert recipe.parameters["weighting.beta"] == 0.02
    assert recipe.parameters["estimator.refractory"] == 5.0
    assert recipe.parameters["motion.avoidance"] == "literal"
    assert find_controller("ssgiff").parameters["weighting.beta"] == 0.01


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(UnknownNameError, match="no controller named 'ssgikff', did you mean"):
        find_controller("ssgikff")
    with pytest.raises(UnknownNameError, match="no parameter of ssgiff named 'betta'"):
        find_controller("ssgiff:betta=1")


@pytest.mark.parametrize("text", ["nc:", "nc:beta", "nc:=1", "nc:beta=", "nc:a=1,", "nc:a=1,a=2"])
def test_a_text_of_another_form_is_refused(text):
    with pytest.raises(ConfigError, match="controller='nc:"):
        parse_controller(text)


@pytest.mark.parametrize("value", ["much", "nan", "inf", "-1"])
def test_a_value_that_does_not_fit_is_refused(value):
    with pytest.raises(ConfigError, match=f"beta='{value}'"):
        find_controller(f"ssgiff:beta={value}")
