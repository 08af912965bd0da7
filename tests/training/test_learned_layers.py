"""Learned layers by hand: other scales, signs or orders would make other policies."""

import math
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
import torch

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.records import Exchange, Heard, Readings, Situation
from swarm_forage_env.record import one_record
from swarm_forage_env.scenarios import find_scenario
from training import learned_weighting, reputation_weighting
from training.exchanges import (
    Exchanges,
    RecordingWeighting,
    _remembered,
    error_of_copying,
)
from training.learned_motion import (
    NETWORK,
    SIZES,
    LearnedMotion,
    NetworkMotion,
    _own_features,
    field_columns,
    motion_network_shapes,
)
from training.learned_weighting import (
    ENCOUNTER_NETWORK,
    HIDDEN,
    LearnedWeighting,
    log_odds,
    scaled_features,
)
from training.linear_motion_policy import (
    FEATURES,
    N_WEIGHTS,
    SHAPES,
    SearchCourse,
    add_residual,
    linear_motion,
    message_features,
    policy_output,
    steer,
    write_features,
)
from training.policy_file import layer_card, observation_layout, save_policy
from training.reputation_weighting import (
    REPUTATION_NETWORK,
    LearnedReputation,
    remembered_features,
)

SCENARIO = find_scenario("es1")
N = len(FEATURES)


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
    columns = field_columns(layout, "situation")
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


def seen(goal, talking=False):
    """What a robot believes, feels and hears: one sender ahead, something close to its left."""
    situation = one(Situation, target=(0.3, 0.4), p=(1.0, 3.0), goal=goal, is_talking=talking)
    readings = one(Readings)
    readings.proximity[6] = 0.1
    heard = one(Heard, n=1, sizes={"slots": 4})
    heard.range_bearing[0] = (0.45, 0.0, 0.0)
    return situation, readings, heard


def test_the_features_of_a_tick_by_hand():
    memory = one(SearchCourse, searched=2.0)
    memory.features[:] = 9.0  # of the tick before
    wheels = np.array([0.2, 0.8], np.float32)
    write_features(*seen(1), wheels, memory, 4.0)
    side, ahead = math.sin(math.radians(50.0)), math.cos(math.radians(50.0))
    expected = [1.0, 0.8, 0.6, 0.15 / 0.65, 3.0 / 5.0, 0.1 * side, 0.1 * ahead, 0.0]
    assert memory.features[:8] == pytest.approx(expected, abs=1e-5)
    assert memory.features[8:] == pytest.approx([0.0, 0.25, 0.25, 0.3], abs=1e-6)
    write_features(*seen(-1), wheels, memory, 4.0)
    expected = [1.0, 0.0, 0.0, 0.15 / 2.15, 2.0 / 4.0]
    assert memory.features[:5] == pytest.approx(expected, abs=1e-5)


def test_a_residual_of_one_turns_full_speed_back_into_full_speed_ahead():
    wheels = np.array([-1.0, 0.5], np.float32)
    add_residual(wheels, 1.0, -0.25)
    assert wheels.tolist() == [1.0, 0.0]
    add_residual(wheels, -0.25, -1.0)
    assert wheels.tolist() == [0.5, -1.0]
    add_residual(wheels, -1.0, 1.0)
    assert wheels.tolist() == [-1.0, 1.0]
    add_residual(wheels, 0.125, 0.5)
    assert wheels.tolist() == [-0.75, 1.0]


@pytest.mark.parametrize(("goal", "searched"), [(-1, 2.0), (0, 0.0)])
def test_the_path_searched_grows_by_the_mean_of_the_wheels_until_there_is_a_goal(goal, searched):
    """Turning on the spot is no path."""
    layer = linear_motion(np.zeros(N_WEIGHTS), SCENARIO)
    numbers = numbers_of(layer.numbers)
    memory = one(SearchCourse, searched=searched)
    for wheels, share in (((0.25, 0.75), 0.5), ((-0.5, 0.5), 0.0), ((-1.0, -1.0), 1.0)):
        before = float(memory.searched)
        steer(*seen(goal), np.array(wheels, np.float32), memory, numbers)
        walked = share * SCENARIO.robot.cruise_speed * SCENARIO.tick if goal < 0 else 0.0
        assert memory.searched == pytest.approx(before + walked)


@pytest.mark.parametrize(("goal", "mode"), [(0, 0), (-1, 1)])
def test_a_policy_corrects_subsumption_and_not_a_robot_that_talks(goal, mode):
    policy = np.zeros(N_WEIGHTS)
    policy[2 * mode * N] = math.atanh(-0.25)  # back, whatever is sensed
    wheels = {}
    for talking in (False, True):
        for own in (np.zeros(N_WEIGHTS), policy):
            numbers = numbers_of(linear_motion(own, SCENARIO).numbers)
            found = np.array([1.0, 1.0], np.float32)
            steer(*seen(goal, talking), found, one(SearchCourse, run=1.0), numbers)
            wheels[talking, bool(own.any())] = found
    expected = np.maximum(wheels[False, False] - 0.5, -1.0)
    np.testing.assert_allclose(wheels[False, True], expected, atol=1e-6)
    np.testing.assert_array_equal(wheels[True, True], wheels[True, False])


@pytest.mark.parametrize(
    ("forward", "turning", "expected"),
    [(9.0, -9.0, (1.0, 0.0)), (9.0, 9.0, (0.0, 1.0)), (-9.0, 9.0, (-1.0, 0.0)),
     (-9.0, -9.0, (0.0, -1.0)), (9.0, 0.0, (1.0, 1.0))],
)  # fmt: skip
def test_a_residual_is_within_full_speed_of_either_wheel(forward, turning, expected):
    x, policy = np.zeros(N), np.zeros(N_WEIGHTS)
    x[0], policy[0], policy[N] = 1.0, forward, turning
    assert policy_output(x, policy, 0)[:2] == pytest.approx(expected, abs=1e-6)


def test_a_sender_to_the_left_ahead_is_felt_on_both_axes_and_no_sender_on_none():
    heard, x = one(Heard, n=2, sizes={"slots": 4}), np.zeros(N)
    heard.range_bearing[:2] = (0.45, math.pi / 6, 0.0), (0.9, 0.0, 0.0)
    message_features(heard, 4.0, x)
    assert x[8:] == pytest.approx([0.125, 0.25 * math.cos(math.pi / 6), 0.5, 0.0], abs=1e-6)
    heard.n, x[8:] = 0, 7.0
    message_features(heard, 4.0, x)
    assert (x[8:] == 7.0).all()


def test_the_networks_of_usual_size_have_so_many_numbers():
    def count(shapes):
        return sum(math.prod(shape) for shape in shapes.values())

    assert SIZES == {"message": 16, "hidden": 64}
    messages, inputs = 16 * 5 + 16, 33 + 2 * 16
    expected = messages + 64 * inputs + 64 + 64 * 64 + 64 + 2 * 64 + 2
    assert count(motion_network_shapes(SIZES)) == expected
    sizes = {"hidden": HIDDEN}
    assert count(ENCOUNTER_NETWORK.shapes(sizes)) == 4 * 8 + 4 + 4 + 8 + 1 + 1
    assert count(REPUTATION_NETWORK.shapes(sizes)) == 4 * 15 + 4 + 4 + 15 + 1 + 1
    assert N_WEIGHTS == count(SHAPES) == 60


def test_a_weighting_among_liars_merges_whole_paths_as_that_of_encounters():
    for rule in (LearnedWeighting(), LearnedReputation()):
        assert rule.layer(SCENARIO).heard_p_share == 1.0


@pytest.mark.parametrize("rule", [LearnedWeighting, LearnedReputation, LearnedMotion])
def test_a_layer_is_asked_for_a_policy_that_fits_it_before_it_runs(rule):
    other = "motion" if rule is not LearnedMotion else "weighting"
    with pytest.raises(ConfigError, match=f"takes the place of {other}, not of"):
        rule(policy=other).check_usable()


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
    narrow = find_scenario("es1", {"radio.slots": "2"})
    for ask in (motion.check_usable, motion.layer, lambda scenario: motion.start(scenario, [1])):
        with pytest.raises(ConfigError, match="does not fit 'es1'"):
            ask(narrow)


def test_a_deep_set_drives_at_most_at_full_speed_and_not_while_it_talks():
    layout = observation_layout("motion", SCENARIO)
    weights = {
        name: np.zeros(shape, np.float32) for name, shape in motion_network_shapes(SIZES).items()
    }
    weights["wheels.bias"][:] = -3.0, 1.5
    observed = np.zeros((SCENARIO.task.n_robots, len(layout)), np.float32)
    situation = layout.situation(observed)
    situation.talking[3] = True
    wheels = NetworkMotion(weights, SCENARIO, 1)(situation)
    assert wheels.tolist() == [[0.0, 0.0] if robot == 3 else [-1.0, 1.0] for robot in range(10)]


def test_a_deep_set_without_one_of_its_arrays_is_refused(tmp_path, make_card):
    sizes = {"message": 2, "hidden": 3}
    arrays = motion_network_shapes(sizes)
    del arrays["wheels.bias"]
    motion = saved(tmp_path, make_card, NETWORK, sizes, arrays)
    with pytest.raises(ConfigError, match=r"array 'motion\.wheels\.bias' is missing"):
        motion.check_usable()


@pytest.mark.parametrize("goal", [0, -1])
def test_only_a_robot_that_searches_changes_its_straight_run(goal):
    """A run that subsumption has shortened by a tick, ten times as slowly if there is no goal."""
    left = {}
    for told in (0.0, 20.0):
        policy = np.zeros(N_WEIGHTS)
        policy[4 * N] = told
        memory = one(SearchCourse, run=1.0)
        situation, readings, heard = seen(goal)
        readings.proximity[:] = 0.0
        numbers = numbers_of(linear_motion(policy, SCENARIO).numbers)
        steer(situation, readings, heard, np.ones(2, np.float32), memory, numbers)
        left[told] = 1.0 - float(memory.run)
    step = SCENARIO.robot.cruise_speed * SCENARIO.tick
    expected = (step, step / 10.0) if goal < 0 else (left[0.0], left[0.0])
    assert (left[0.0], left[20.0]) == pytest.approx(expected)


def test_not_to_know_an_area_counts_as_an_error_of_four_tenths_of_a_metre():
    known_to_nobody = torch.tensor([0.0]), torch.tensor([[0.3, 0.0]])
    assert float(error_of_copying(*known_to_nobody)) == pytest.approx(0.15)


def test_exchanges_in_which_everybody_knew_better_teach_nothing():
    row, near, far = np.ones(2, np.float32), [[0.1, 0.0]] * 2, [[0.4, 0.0]] * 2
    near, far = np.array(near, np.float32), np.array(far, np.float32)
    taught = Exchanges(row[:, None], np.eye(2, dtype=np.float32), row, far, near)
    assert float(taught.gain("es1")) == pytest.approx(0.16 - 0.01)
    with pytest.raises(ConfigError, match="scenario 'es1': in 2 exchanges nobody who knew"):
        replace(taught, own_error=near, heard_error=far).gain("es1")


def test_no_exchanges_have_the_columns_of_some():
    nothing = Exchanges.of([], 7)
    assert [each.shape for each in nothing._columns] == [(0, 7), (0, 2), (0,), (0, 2), (0, 2)]
    rows = np.arange(3, dtype=np.float32)
    pair = np.stack([rows, rows], axis=1)
    batch = Exchanges(rows[:, None], pair, rows, pair, pair).draw(torch.Generator().manual_seed(1))
    assert [len(each) for each in batch._columns] == [1024] * 5
    assert all((each.reshape(1024, -1)[:, 0] == batch.known).all() for each in batch._columns)


def test_what_is_recorded_of_memory_is_of_the_area_and_the_partner():
    told = np.array([exchange(), exchange()])
    told["right"] = 3.0, 5.0
    found = _remembered(told, np.array([1, 0]), np.array([1, 0]))
    expected = [[0, 1, 5.0, 1.5, 2.0, 0.1, 0.6], [1, 0, 3.0, 1.5, 0.2, 0.9, 1.4]]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("remembers", [False, True])
def test_a_recorder_tells_how_many_numbers_an_observation_has(remembers):
    layout = observation_layout("weighting", SCENARIO)
    network = REPUTATION_NETWORK if remembers else ENCOUNTER_NETWORK
    recording = RecordingWeighting(np.zeros(1, np.float32), layout, network)
    assert recording.n_numbers == 20 + 7 * remembers
    assert recording.heard_p_share == 1.0
    for each, name in ((recording, "numbers"), (network, "gain"), (Exchanges.of([], 1), "known")):
        with pytest.raises(FrozenInstanceError):
            setattr(each, name, None)
