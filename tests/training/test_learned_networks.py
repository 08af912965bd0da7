"""Networks of learned layers: their equations by hand, what fits them, and that they run."""

import dataclasses
import math

import numpy as np
import pytest

from baselines.evaluation.experiment_config import ExperimentConfig
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.record import one_record
from swarm_forage_env.scenarios import find_scenario
from training.dagger import WeightingActor
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    LearnedReputation,
    LearnedWeighting,
    gain,
    log_odds,
    remembered_features,
    reputation_gain,
    scaled_features,
)
from training.linear_motion_policy import LINEAR_MOTION, LearnedMotion
from training.policy_file import layer_card, load_policy, observation_layout, save_policy

SCENARIO = find_scenario("es1", {"task.n_robots": 3})


def test_a_motion_fits_worlds_that_show_what_it_was_trained_on(tmp_path, make_card):
    card = make_card(layers={"motion": layer_card("motion", SCENARIO, LINEAR_MOTION.name, {})})
    shapes = LINEAR_MOTION.shapes({})
    weights = {f"motion.{name}": np.zeros(shape, np.float32) for name, shape in shapes.items()}
    save_policy(tmp_path / "mine.safetensors", weights, card)
    motion = LearnedMotion(policy=str(tmp_path / "mine.safetensors"))
    alone, many = (find_scenario("es1", {"task.n_robots": n}) for n in (1, 9))
    for scenario in (None, SCENARIO, alone, many, find_scenario("waypoints-05")):
        motion.check_usable(scenario)
    narrow = find_scenario("es1", {"radio.slots": "1"})
    for ask in (motion.check_usable, motion.layer):
        with pytest.raises(ConfigError, match="does not fit 'es1'"):
            ask(narrow)


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [("motion", LearnedWeighting), ("weighting", LearnedReputation),
     ("weighting-sceptical", LearnedWeighting), ("weighting", LearnedMotion)],
)  # fmt: skip
def test_a_policy_of_another_architecture_is_refused(wrong, rule):
    for refuses in (rule(policy=wrong).check_usable, rule(policy=wrong).layer):
        with pytest.raises(ConfigError):
            refuses(SCENARIO)


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
    units = [math.tanh(0.5 * 0.2 - 1.0 * -0.3 + 0.1), math.tanh(2.0 * 0.2 + 0.25 * -0.3 - 0.2)]
    expected = 1.3 * 1.5 + 0.7 * 0.2 - 0.6 * -0.3 + 3.0 * units[0] - 4.0 * units[1] + 0.05
    numbers = np.array([*hidden, *biases, *outputs, *direct, bias])
    assert log_odds(x, ahead, numbers) == pytest.approx(expected)


@pytest.mark.parametrize(("gain", "features"), [(gain, 8), (reputation_gain, 15)])
def test_a_weight_is_the_logistic_function_of_the_log_odds(gain, features):
    """All numbers zero but the bias: SGIFF of steepness 1 of the paths, plus a constant."""
    network = np.zeros(4 * features + 4 + 4 + features + 1 + 1)
    network[-1] = 0.5
    told = gain(exchange(), 0, numbers_of({"network": network}))
    assert told == pytest.approx(1.0 / (1.0 + math.exp(-(0.4 - 2.5 + 0.5))), abs=1e-6)


def test_another_policy_under_the_same_name_is_another_configuration(policy_file):
    controller = dataclasses.replace(
        find_controller("ssgiff"), weighting=LearnedWeighting(policy=str(policy_file))
    )
    first = ExperimentConfig("x", find_scenario("es1"), controller).key
    policy = load_policy(policy_file)
    save_policy(policy_file, {k: 2.0 * w for k, w in policy.weights.items()}, policy.card)
    assert ExperimentConfig("x", find_scenario("es1"), controller).key != first


def test_a_network_begins_near_zero_and_its_hidden_units_orthogonal():
    actor = WeightingActor(observation_layout("weighting", find_scenario("es1")), hidden=4)
    arrays = actor.to_numpy()
    assert {name: array.shape for name, array in arrays.items()} == {
        name: tuple(shape) for name, shape in EXCHANGE_NETWORK.shapes({"hidden": 4}).items()
    }
    first = arrays["hidden.weight"]
    assert first @ first.T == pytest.approx(2.0 * np.eye(4), abs=1e-5)
    assert not arrays["output.weight"].any()
    arrays["output.bias"][...] = 3.0
    assert actor.arrays["output.bias"].item() == 0.0, "arrays are copies"
    actor.load_numpy(arrays)
    assert actor.arrays["output.bias"].item() == 3.0
