"""Learned layers by hand: other scales, signs or orders would make other policies."""

import math

import numpy as np
import pytest

from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.record import one_record
from swarm_forage_env.scenarios import find_scenario
from training import learned_weighting, reputation_weighting
from training.learned_motion import (
    _own_features,
    motion_network_shapes,
)
from training.learned_weighting import log_odds, scaled_features
from training.policy_file import observation_layout
from training.reputation_weighting import remembered_features

SCENARIO = find_scenario("es1")


def one(kind, **numbers):
    """A record of one robot with some of its numbers set."""
    record = kind.array((1,), **numbers.pop("sizes", {})).view(np.recarray)[0]
    for name, value in numbers.items():
        record[name] = value
    return record


def numbers_of(layer):
    """The record of a layer's numbers, as its functions are handed it."""
    return one_record(layer).view(np.recarray)[0]


def exchange():
    """An exchange in which every number is another."""
    return one(
        Exchange,
        is_valid=True,
        own_p=(0.4, 6.0), heard_p=(2.5, 0.9), disagreement=(0.3, 1.2),
        own_distance=(0.5, 1.1), heard_distance=(0.7, 0.2), n_averaged=12, range=0.11,
        own_known=(1, 0), own_visited=(0, 1), right=3.0, wrong=1.5,
        support=(0.2, 2.0), suspicion=(0.9, 0.1), dissent=(1.4, 0.6),
    )  # fmt: skip


def squashed(x, unit, centre, spread):
    """(ln(1 + x / u) - c) / s."""
    return (math.log(1.0 + x / unit) - centre) / spread


def test_what_a_weighting_sees_of_an_exchange_by_hand():
    expected = [
        squashed(6.0, 0.1, 3.0, 1.5), squashed(0.9, 0.1, 3.0, 1.5), squashed(1.2, 0.1, 2.0, 1.5),
        squashed(0.4, 0.1, 3.0, 1.5), squashed(1.1, 0.1, 2.0, 1.0), squashed(0.2, 0.1, 2.0, 1.0),
        squashed(12.0, 1.0, 3.5, 1.5), squashed(0.11, 0.1, 0.75, 0.25),
    ]  # fmt: skip
    assert scaled_features(exchange(), 1) == pytest.approx(expected, abs=1e-5)
    assert scaled_features(exchange(), 0)[3] == pytest.approx(expected[0], abs=1e-5)


def test_what_a_weighting_sees_of_what_is_remembered_by_hand():
    expected = [
        squashed(0.0, 1.0, 0.35, 0.35), squashed(1.0, 1.0, 0.35, 0.35),
        squashed(3.0, 1.0, 0.7, 0.7), squashed(1.5, 1.0, 0.7, 0.7), squashed(2.0, 0.5, 0.7, 0.7),
        squashed(0.1, 0.5, 0.7, 0.7), squashed(0.6, 0.5, 0.7, 0.7),
    ]  # fmt: skip
    assert remembered_features(exchange(), 1) == pytest.approx(expected, abs=1e-5)
    known = squashed(1.0, 1.0, 0.35, 0.35), squashed(0.0, 1.0, 0.35, 0.35)
    assert remembered_features(exchange(), 0)[:2] == pytest.approx(known, abs=1e-5)


def test_the_log_odds_of_a_network_of_two_units_and_two_features_by_hand():
    """V, v, w, (d, d_0), b in the order in which they lie in a file."""
    hidden, biases, outputs = (0.5, -1.0, 2.0, 0.25), (0.1, -0.2), (3.0, -4.0)
    direct, bias = (0.7, -0.6, 0.3), 0.05
    x, ahead = (0.2, -0.3), 1.5
    units = [
        math.tanh(0.5 * 0.2 - 1.0 * -0.3 + 0.1),
        math.tanh(2.0 * 0.2 + 0.25 * -0.3 - 0.2),
    ]
    expected = 1.3 * 1.5 + 0.7 * 0.2 - 0.6 * -0.3 + 3.0 * units[0] - 4.0 * units[1] + 0.05
    numbers = np.array([*hidden, *biases, *outputs, *direct, bias])
    assert log_odds(x, ahead, numbers) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("module", "features"), [(learned_weighting, 8), (reputation_weighting, 15)]
)
def test_a_weight_is_the_logistic_function_of_the_log_odds(module, features):
    """All numbers zero but the bias: SGIFF of steepness 1 of the paths, plus a constant."""
    network = np.zeros(4 * features + 4 + 4 + features + 1 + 1)
    network[-1] = 0.5
    told = module.gain(exchange(), 0, numbers_of({"network": network}))
    assert told == pytest.approx(1.0 / (1.0 + math.exp(-(0.4 - 2.5 + 0.5))), abs=1e-6)


def test_what_a_motion_sees_of_its_robot_by_hand():
    """Plain fields, then p, then of target, nest and prey cosines, sines and both distances."""
    layout = observation_layout("motion", SCENARIO)
    columns = layout.columns("situation")
    row = np.zeros((1, len(layout)), np.float32)
    shown = {
        "proximity": np.linspace(0.1, 0.8, 8), "ground": (0.9, 0.2, 0.3), "known": (1, 0),
        "goal": (0, 1, 0), "talking": 1, "wheels": (0.25, -0.5), "p": (2.0, 6.0),
        "target": (0.0, 0.15), "areas": (-1.5, 0.0, 0.0, 0.0),
    }  # fmt: skip
    for name, numbers in shown.items():
        row[0, columns[name]] = numbers
    plain = [*np.linspace(0.1, 0.8, 8), 0.9, 0.2, 0.3, 1, 0, 0, 1, 0, 1, 0.25, -0.5]
    places = [0, -1, 0, 1, 0, 0, 0.5, 1.5 / 1.65, 0, 0.15 / 1.65, 0.5, 0]
    found = _own_features(row, columns, np)[0]
    np.testing.assert_allclose(found, [*plain, 0.5, 0.75, *places], atol=2e-5)
    shapes = motion_network_shapes({"message": 5, "hidden": 7})
    assert shapes["first.weight"] == (7, len(found) + 2 * 5)
    assert shapes["message.weight"] == (5, 5)
