"""Forms of actions: a speed ahead and a turn, wheels, weights about zero, choices."""

import numpy as np
import pytest
from gymnasium.spaces import Discrete
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env import ArrayEnv, ConfigError, UnknownNameError, parallel_env
from swarm_forage_env.scenarios import find_scenario
from training.policy_controller import policy_controller

FEW = {"task.n_robots": 3, "physics": "kinematic"}


def wheels_after(given, **options):
    env = ArrayEnv("es1", 1, **FEW, **options)
    env.reset(0)
    env.step(np.array([[given] * 3]))
    return env.world.robots["command"]["wheels"][0, 0]


def test_the_usual_action_is_a_drive_and_wheels_are_wheels():
    assert_allclose(wheels_after([0.0, 0.0]), [1.0, 1.0])
    assert_allclose(wheels_after([0.0, 0.0], action="drive-v1"), [0.5, 0.5])
    assert_allclose(wheels_after([-1.0, 1.0], sharpest_turn=0.5), [-0.5, 0.5])
    assert_allclose(wheels_after([-1.0, 0.25], action="wheels"), [-1.0, 0.25])
    assert_allclose(wheels_after(5, residual=True, discrete=True), wheels_after([0, 0], residual=1))


@pytest.mark.parametrize(
    ("learn", "discrete", "n"),
    [
        ("motion", True, 5),
        ("motion", (3, 4), 12),
        ("weighting", True, 9),
        ("weighting", (2, 4), 8),
        ("both", True, 45),
        ("everything", True, 25),
    ],
)
def test_choices_are_counted(learn, discrete, n):
    env = parallel_env("es1", learn=learn, discrete=discrete, **FEW)
    assert env.action_space("epuck_0") == Discrete(n)
    env.reset(seed=0)
    for choice in (0, n - 1):
        env.step(dict.fromkeys(env.agents, choice))


def test_the_five_drives_go_ahead_or_turn_on_either_side():
    wheels = [wheels_after(choice, discrete=True) for choice in range(5)]
    turns = [np.sign(right - left) for left, right in wheels]
    assert turns == [0.0, 1.0, -1.0, 1.0, -1.0]
    assert_allclose([sum(each) > 0.1 for each in wheels], [True, True, True, False, False])


def test_the_last_number_of_a_choice_varies_fastest():
    env = ArrayEnv("es1", 1, learn="weighting", discrete=(5, 5), normalise=False, **FEW)
    choices = env.actions.form.choices
    assert choices[1].tolist() == [0.0, 0.25]
    assert choices[24].tolist() == [1.0, 1.0]


def test_a_robot_says_nothing_or_one_of_four_words():
    env = ArrayEnv("es1", 1, learn="everything", discrete=True, **FEW)
    env.reset(0)
    env.step(np.array([[0, 1, 4]]))
    minds = env.loop.controller.minds
    assert_array_equal(minds["speak"][0], [-1.0, 1.0, 1.0])
    assert_array_equal(minds["words"][0].argmax(axis=1), [0, 0, 3])
    assert_array_equal(minds["words"][0].sum(axis=1), [0.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"action": "wheel"}, UnknownNameError, "no form of action named 'wheel', did you mean"),
        ({"action": "drive", "residual": True}, ConfigError, "use action='wheels'"),
        ({"discrete": (0, 3)}, ConfigError, r"^discrete=\(0, 3\): must be True, False, or"),
        ({"discrete": 3}, ConfigError, r"^discrete=3: must be True, False, or \(n, m\) for"),
        ({"sharpest_turn": 1.5}, ConfigError, r"sharpest_turn=1\.5"),
    ],
)
def test_a_form_that_cannot_be_had_is_refused(options, error, message):
    with pytest.raises(error, match=message):
        parallel_env("es1", **options)


@pytest.mark.timeout(20)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"discrete": (3000, 3000)}, "gives 9000000 actions; must give at most 4096, because"),
        ({"discrete": (10**12, 1)}, "gives 1000000000000 actions; must give at most 4096"),
        ({"discrete": (10**400, 10**5000)}, "gives <int of thousands of digits> actions"),
        ({"discrete": (20, 200), "learn": "both"}, "gives 36000 actions; must give at most 4096"),
        ({"stack": 1001}, "stack=1001: must be at most 1000, because a network has one"),
        ({"stack": 10**5000}, "stack=<int of thousands of digits>: must be at most 1000"),
    ],
)
def test_a_size_without_measure_is_refused_before_anything_is_built(options, message):
    with pytest.raises(ConfigError, match=message):
        parallel_env("es1", **options)
    with pytest.raises(ConfigError, match=message):
        policy_controller(np.zeros_like, **options).check_usable(find_scenario("es1"))


@pytest.mark.parametrize("bad", [-1, 5, 1.0, None, [10**5000], [[0, 1], [0]]])
def test_a_choice_that_is_none_is_refused_by_name(bad):
    env = parallel_env("es1", discrete=True, **FEW)
    env.reset(seed=0)
    with pytest.raises(ConfigError, match=r"of epuck_1: .*must be a whole number from 0 to 4"):
        env.step({"epuck_0": 0, "epuck_1": bad, "epuck_2": 0})
