"""The named controllers: their layers, their parameters, old names, and names put together."""

import math
import warnings

import numpy as np
import pytest

from baselines.controllers import OLD_NAMES
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import Message
from baselines.estimators.covariance_intersection import CovarianceIntersection
from baselines.estimators.dead_reckoning import DeadReckoning
from baselines.estimators.message_exchange import round_estimate
from baselines.estimators.reputation_odometry import ReputationOdometryParameters
from baselines.estimators.sikf import SIKFParameters
from baselines.estimators.social_odometry import SocialOdometryParameters
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError, RenamedWarning, UnknownNameError
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import override
from swarm_forage_env.raw_control import estimators_of
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario


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


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"beta": "steep"}, "beta='steep': must be a valid number"),
        ({"beta": -1.0}, "beta=-1.0: must be greater than or equal to 0"),
        ({"beta": math.nan}, "beta=nan: must be a finite number"),
        ({"beta": math.inf}, "beta=inf: must be a finite number"),
        ({"beta": math.nextafter(1e6, math.inf)}, "beta=1000000.0"),
        ({"lost_within": 0.0}, "lost_within=0.0: must be greater than 0"),
        ({"double": "both"}, "double='both': must be a valid boolean"),
        ({"avoidance": "leteral"}, "avoidance='leteral': must be 'tangential' or"),
        ({"gap": 0.2}, "gap=0.2: must be less than or equal to 0.05"),
        ({"gap": 0.01, "motion.gap": 0.02}, "motion.gap: is given twice, as 'gap' and as 'motion"),
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


MOST = {"overshoot": math.nextafter(1.0, 2.0)}


@pytest.mark.parametrize(
    "name", [name for name, value in ReputationOdometryParameters() if type(value) is float]
)
def test_a_length_or_time_is_not_negative_and_some_are_bounded(name):
    made = ReputationOdometryParameters()
    for wrong in (-1e-9, math.nan, MOST.get(name, math.inf)):
        with pytest.raises(ConfigError, match=name):
            override(made, {name: wrong})
    if name != "lost_within":  # which test_controllers refuses
        assert getattr(override(made, {name: 0.0}), name) == 0.0


def test_social_odometry_reads_its_times_in_ticks_and_its_lengths_from_the_scenario():
    changes = {"tick": 0.5, "exchange_time": 2.0, "axle": 0.06, "area_radius": 0.2,
               "area_distance": 1.0, "ground_ahead": 0.03}  # fmt: skip
    scenario = find_scenario("es1", changes)
    made = SocialOdometryParameters(
        refractory=21.0, pause=14.0, deaf_when_lost=6.0, tells_within=2.5, listens_above=0.5,
        message_path=0.1, lost_within=0.07, overshoot=0.3, double=True, speaks=False,
        first_hand=False, payload="int8",
    )  # fmt: skip
    assert made.numbers(scenario) == pytest.approx({
        "speaks": 0.0, "double": 1.0, "first_hand": 0.0, "message_path": 0.1, "tells_within": 2.5,
        "listens_above": 0.5, "lost_within": 0.07, "overshoot": 0.3, "talk_ticks": 4,
        "refractory_ticks": 42, "pause_ticks": 28, "deaf_ticks": 12, "axle": 0.06,
        "to_centre": 0.23, "n_steps": 256.0,
    })  # fmt: skip


def test_an_exchange_takes_a_tick_at_least_and_zero_means_that_all_is_told():
    scenario = find_scenario("es1", {"exchange_time": 0.01})
    numbers = SocialOdometryParameters(pause=1e12).numbers(scenario)
    assert numbers["talk_ticks"] == 1
    assert numbers["pause_ticks"] == 10**9  # the longest episode, counted in 32 bits
    assert numbers["tells_within"] == math.inf


@pytest.mark.parametrize("n", [2.0**16, 2.0**8])
def test_what_is_told_is_a_whole_multiple_of_the_steps_of_its_words(n):
    message = Message.array((1,))[0]
    estimates = {"distance": (0.777, 99.0), "p": (12.3456, 1e6), "direction": (-3.1415, 1.234)}
    for name, values in estimates.items():
        message[name] = values
    for area in range(2):
        round_estimate(message, area, n)
    steps = {"distance": 8.192 / n, "p": 131.072 / n, "direction": 2.0 * math.pi / n}
    for name, step in steps.items():
        words = message[name].astype(np.float64) / step
        assert np.allclose(words, np.rint(words), atol=0.01)
        off = abs(float(message[name][0]) - estimates[name][0])
        assert min(off, abs(off - 2.0 * math.pi)) <= 0.5 * step + 1e-6
    assert message["distance"][1] == np.float32((n - 1.0) * 8.192 / n)
    assert message["p"][1] == np.float32((n - 1.0) * 131.072 / n)


def test_robots_tell_words_where_the_payload_says_so():
    loop = Loop(find_scenario("es1"), find_controller("ssgikf:payload=int8"), [0], "kinematic")
    loop.run(1500)
    message = estimators_of(loop.controller.minds)["message"][0]
    words = message["p"][message["has_estimate"] != 0] / (131.072 / 256)
    assert words.max() > 1.0
    assert np.allclose(words, np.rint(words), atol=1e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [("message_path", 1.0), ("tells_within", 1.0), ("listens_above", 1.0), ("payload", "int8")],
)
def test_where_a_covariance_is_told_no_path_can_be_set_or_rounded(name, value):
    with pytest.raises(ConfigError, match=f"{name}: applies to path lengths"):
        override(SIKFParameters(), {name: value})


@pytest.mark.parametrize("name", ["decentralised_ekf", "covariance_intersection",
                                  "dead_reckoning"])  # fmt: skip
def test_the_authors_setting_is_refused_where_robots_forage(name):
    made = ESTIMATORS[name](setting="authors")
    with pytest.raises(ConfigError, match="setting='authors': is for robots that visit waypoints"):
        made.layer(find_scenario("es1"))
    assert made.layer(find_scenario("waypoints-05")) is not None
    assert ESTIMATORS[name]().setting == "corrected"
