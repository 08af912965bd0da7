"""What an estimator is told of its scenario, and within which bounds it can be set."""

import math

import numpy as np
import pytest

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import Message
from baselines.estimators.message_exchange import round_estimate
from baselines.estimators.reputation_odometry import ReputationOdometryParameters
from baselines.estimators.sikf import SIKFParameters
from baselines.estimators.social_odometry import SocialOdometryParameters
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import override
from swarm_forage_env.raw_control import estimators_of
from swarm_forage_env.scenarios import find_scenario

MOST = {"overshoot": math.nextafter(1.0, 2.0)}


@pytest.mark.parametrize(
    "name",
    [name for name, value in ReputationOdometryParameters() if type(value) is float],
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
    numbers = SocialOdometryParameters().numbers(scenario)
    assert numbers["talk_ticks"] == 1
    assert numbers["tells_within"] == math.inf


@pytest.mark.parametrize("n", [2.0**16, 2.0**8])
def test_what_is_told_is_a_whole_multiple_of_the_steps_of_its_words(n):
    message = Message.array((1,))[0]
    told = {"distance": (0.777, 99.0), "p": (12.3456, 1e6), "direction": (-3.1415, 1.234)}
    for name, values in told.items():
        message[name] = values
    for area in range(2):
        round_estimate(message, area, n)
    steps = {"distance": 8.192 / n, "p": 131.072 / n, "direction": 2.0 * math.pi / n}
    for name, step in steps.items():
        words = message[name].astype(np.float64) / step
        assert np.allclose(words, np.rint(words), atol=0.01)
        off = abs(float(message[name][0]) - told[name][0])
        assert min(off, abs(off - 2.0 * math.pi)) <= 0.5 * step + 1e-6
    assert message["distance"][1] == np.float32((n - 1.0) * 8.192 / n)
    assert message["p"][1] == np.float32((n - 1.0) * 131.072 / n)


def test_robots_tell_words_where_the_payload_says_so():
    loop = Loop(find_scenario("es1"), find_controller("ssgikf:payload=int8"), [0], "kinematic")
    loop.run(1500)
    message = estimators_of(loop.controller.minds)["message"][0]
    words = message["p"][message["told"] != 0] / (131.072 / 256)
    assert words.max() > 1.0
    assert np.allclose(words, np.rint(words), atol=1e-3)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [({name: 1.0}, f"{name}.*is a path") for name in ("message_path", "tells_within",
                                                      "listens_above")]
    + [({"payload": "int8"}, "payload=int8: rounds paths")],
)  # fmt: skip
def test_where_a_covariance_is_told_no_path_can_be_set_or_rounded(wrong, told):
    with pytest.raises(ConfigError, match=told):
        override(SIKFParameters(), wrong)


@pytest.mark.parametrize("name", ["decentralised_ekf", "covariance_intersection",
                                  "dead_reckoning"])  # fmt: skip
def test_the_authors_setting_is_refused_where_robots_forage(name):
    made = ESTIMATORS[name](setting="authors")
    with pytest.raises(ConfigError, match="setting='authors': is of robots that visit waypoints"):
        made.layer(find_scenario("es1"))
    assert made.layer(find_scenario("waypoints-05")) is not None
    assert ESTIMATORS[name]().setting == "corrected"
