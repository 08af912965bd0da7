"""The networks of learned layers against plain statements of their equations; what fits them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.policies import LEARNABLE
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.record import one_record
from swarm_forage_env.scenarios import find_scenario
from tests.outside import motion_inputs
from training.learned_motion import (
    NETWORK,
    LearnedMotion,
    NetworkMotion,
    _message_features,
    _own_features,
    motion_network_shapes,
    wheel_speeds,
)
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    REPUTATION_NETWORK,
    LearnedReputation,
    LearnedWeighting,
    flatten,
    gain,
    log_odds,
    network_over,
    remembered_features,
    reputation_gain,
    scaled_features,
    unflatten,
)
from training.policy_file import layer_card, load_policy, observation_layout, save_policy

SCENARIO = find_scenario("es1", {"task.n_robots": 3})
LAYOUT = observation_layout("motion", SCENARIO)
COLUMNS = LAYOUT.columns("situation")


def shown(rows=6, seed=0):
    """Situations with anything in them, some robots of which talk."""
    rng = np.random.default_rng(seed)
    observed = rng.normal(size=(rows, len(LAYOUT))).astype(np.float32)
    for name in ("known", "heard"):
        observed[:, COLUMNS[name]] = observed[:, COLUMNS[name]] > 0
    observed[:, COLUMNS["p"]] = np.abs(observed[:, COLUMNS["p"]])
    observed[:, COLUMNS["goal"]] = np.resize(np.eye(3), (rows, 3))
    observed[:, COLUMNS["talking"]] = np.arange(rows)[:, None] % 3 == 2
    return LAYOUT.records(observed)


def random_weights(scale=0.5):
    rng = np.random.default_rng(1)
    shapes = motion_network_shapes({"message": 3, "hidden": 4})
    return {
        name: rng.normal(0.0, scale, shape).astype(np.float32) for name, shape in shapes.items()
    }


def test_columns_are_those_of_a_part_wherever_it_stands():
    names = list(LAYOUT.names)
    for name, columns in COLUMNS.items():
        stems = {each.split(".")[1] for each in names[columns]}
        assert stems == {name}
    assert sum(len(names[columns]) for columns in COLUMNS.values()) == len(names)
    after = LEARNABLE["both"].layout(SCENARIO, has_walk=False).columns("situation")
    assert after["proximity"] == slice(20, 28)


def test_a_motion_network_computes_its_equation():
    seen, weights = shown(), random_weights()
    observed, heard = LAYOUT.matrix(seen), seen["heard"]
    own = _own_features(observed, COLUMNS, np)
    felt = _message_features(heard.range_bearing, np)
    expected = []
    for row in range(len(observed)):
        told = [
            full * np.tanh(weights["message.weight"] @ each + weights["message.bias"])
            for full, each in zip(heard.is_valid[row], felt[row], strict=True)
        ]
        z = np.concatenate([own[row], np.sum(told, axis=0), np.max(told, axis=0)])
        for name in ("first", "second"):
            z = np.tanh(weights[f"{name}.weight"] @ z + weights[f"{name}.bias"])
        expected.append(weights["wheels.weight"] @ z + weights["wheels.bias"])
    wheels = wheel_speeds(weights, observed, COLUMNS, np)
    np.testing.assert_allclose(wheels, expected, atol=1e-5)
    assert wheels.dtype == np.float32
    tensors = {name: torch.from_numpy(array) for name, array in weights.items()}
    same = wheel_speeds(tensors, torch.from_numpy(observed), COLUMNS, torch)
    np.testing.assert_allclose(same.numpy(), expected, atol=1e-5)


def test_wheels_are_bounded_and_stand_while_a_robot_talks():
    seen = shown()
    for scale in (0.1, 5.0):
        weights = random_weights(scale)
        wheels = NetworkMotion(weights, SCENARIO)(*motion_inputs(seen))
        free = wheel_speeds(weights, LAYOUT.matrix(seen), COLUMNS, np)
        talks = seen["situation"].is_talking[:, None] > 0
        expected = np.where(talks, 0.0, np.clip(free, -1.0, 1.0))
        np.testing.assert_array_equal(wheels, expected)
    assert {-1.0, 0.0, 1.0} <= set(wheels.ravel().tolist())


def saved(tmp_path, make_card, network, sizes, arrays):
    """A file with these arrays of a motion."""
    card = make_card(layers={"motion": layer_card("motion", SCENARIO, network, sizes)})
    weights = {f"motion.{name}": np.zeros(shape, np.float32) for name, shape in arrays.items()}
    save_policy(tmp_path / "mine.safetensors", weights, card)
    return LearnedMotion(policy=str(tmp_path / "mine.safetensors"))


def test_a_motion_fits_worlds_that_show_what_it_was_trained_on(tmp_path, make_card):
    sizes = {"message": 2, "hidden": 3}
    motion = saved(tmp_path, make_card, NETWORK, sizes, motion_network_shapes(sizes))
    for scenario in (None, SCENARIO, find_scenario("waypoints-05")):
        motion.check_usable(scenario)
    assert motion.layer(SCENARIO) is None
    narrow = find_scenario("es1", {"radio.slots": "1"})
    for ask in (motion.check_usable, motion.layer, lambda scenario: motion.start(scenario, [1])):
        with pytest.raises(ConfigError, match="does not fit 'es1'"):
            ask(narrow)


def test_a_deep_set_without_one_of_its_arrays_is_refused(tmp_path, make_card):
    sizes = {"message": 2, "hidden": 3}
    arrays = motion_network_shapes(sizes)
    del arrays["wheels.bias"]
    motion = saved(tmp_path, make_card, NETWORK, sizes, arrays)
    with pytest.raises(ConfigError, match=r"array 'motion\.wheels\.bias' is missing"):
        motion.check_usable()


def test_flat_weights_lie_in_the_order_of_the_shapes():
    shapes = {"b": (2, 2), "a": (3,), "c": (1,)}
    arrays = unflatten(np.arange(8.0), shapes)
    assert arrays["b"].tolist() == [[0.0, 1.0], [2.0, 3.0]]
    assert (arrays["a"].tolist(), arrays["c"].tolist()) == ([4.0, 5.0, 6.0], [7.0])
    assert arrays["a"].dtype == np.float32
    assert flatten(arrays, shapes).tolist() == list(range(8))


@pytest.mark.parametrize(
    ("network", "rule", "policy"),
    [
        (EXCHANGE_NETWORK, LearnedWeighting, "weighting"),
        (REPUTATION_NETWORK, LearnedReputation, "weighting-sceptical"),
    ],
)
def test_a_rule_runs_the_network_of_its_policy(network, rule, policy):
    layer = rule().layer(SCENARIO)
    rule().check_usable()
    assert rule().policy == policy
    assert [file.stem for file in rule().reads] == [policy]
    assert layer.gain is network.gain
    assert layer.heard_p_share == 1.0
    loaded = load_policy(policy)
    np.testing.assert_array_equal(layer.all_numbers["network"], network.numbers_of(loaded))
    assert len(network.features) == len(network.scales)
    assert network.shapes({"hidden": 2})["direct.weight"] == (len(network.features) + 1,)


def test_a_network_is_run_in_single_precision():
    layer = EXCHANGE_NETWORK.layer(np.array([0.1, 0.2]))
    assert layer.all_numbers["network"].tolist() == [np.float32(0.1), np.float32(0.2)]


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [("motion", LearnedWeighting), ("weighting", LearnedReputation),
     ("weighting-sceptical", LearnedWeighting), ("weighting", LearnedMotion)],
)  # fmt: skip
def test_a_policy_of_another_architecture_is_refused(wrong, rule):
    for refuses in (rule(policy=wrong).check_usable, rule(policy=wrong).layer):
        with pytest.raises(ConfigError):
            refuses(SCENARIO)


@pytest.mark.parametrize(
    ("estimator", "network"),
    [
        (SimpleNamespace(weighs_unknown=True), REPUTATION_NETWORK),
        (SimpleNamespace(weighs_unknown=False), EXCHANGE_NETWORK),
        (SimpleNamespace(), EXCHANGE_NETWORK),
    ],
)
def test_a_network_over_an_estimator_that_remembers_is_shown_what_it_remembers(estimator, network):
    assert network_over(estimator) is network


ES1 = find_scenario("es1")


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


@pytest.mark.parametrize(("gain", "features"), [(gain, 8), (reputation_gain, 15)])
def test_a_weight_is_the_logistic_function_of_the_log_odds(gain, features):
    """All numbers zero but the bias: SGIFF of steepness 1 of the paths, plus a constant."""
    network = np.zeros(4 * features + 4 + 4 + features + 1 + 1)
    network[-1] = 0.5
    told = gain(exchange(), 0, numbers_of({"network": network}))
    assert told == pytest.approx(1.0 / (1.0 + math.exp(-(0.4 - 2.5 + 0.5))), abs=1e-6)


def test_what_a_motion_sees_of_its_robot_by_hand():
    """Plain fields, then p, then of target, nest and prey cosines, sines and both distances."""
    layout = observation_layout("motion", ES1)
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
