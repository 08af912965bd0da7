"""The learned weighting: the hand-written rule at zero weights, and each network for itself."""

import dataclasses
import math

import numpy as np
import pytest

from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.weighting.rows import RowWeighting
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from tests.outside import exchanges
from training.candidate_rollouts import CandidateRollouts
from training.learned_weighting import EXCHANGE_NETWORK, HIDDEN, LearnedWeighting
from training.policy_file import load_policy, save_policy

SHAPES = EXCHANGE_NETWORK.shapes({"hidden": HIDDEN})
N_NUMBERS = sum(math.prod(shape) for shape in SHAPES.values())


def random_networks(count, seed=0):
    return np.random.default_rng(seed).normal(0.0, 0.5, (count, N_NUMBERS)).astype(np.float32)


def encounters(rows, seed=0):
    rng = np.random.default_rng(seed)
    p = rng.exponential(5.0, (2, rows, 2)).astype(np.float32)
    return exchanges(
        rows, is_valid=rng.random(rows) < 0.5, own_p=p[0], heard_p=p[1],
        disagreement=rng.exponential(0.5, (rows, 2)), own_distance=rng.exponential(1.0, (rows, 2)),
        heard_distance=rng.exponential(1.0, (rows, 2)), range=rng.uniform(0.07, 0.15, rows),
        n_averaged=rng.integers(1, 250, rows),
    )  # fmt: skip


def weigh(network, seen):
    return RowWeighting(EXCHANGE_NETWORK.layer(network))(seen)


def test_zero_weights_are_sgiff():
    seen = encounters(500)
    ended = seen.is_valid > 0
    g = weigh(np.zeros(N_NUMBERS), seen)
    expected = RowWeighting(SGIFF(beta=0.01).layer(find_scenario("es1")))(seen)
    np.testing.assert_allclose(g[ended], expected[ended], rtol=1e-4, atol=1e-7)
    assert not g[~ended].any()


def test_extreme_encounters_give_shares():
    seen = exchanges(
        4,
        own_p=np.array([[0, 0], [1e30, 0], [0, 1e30], [1e30, 1e30]], np.float32),
        heard_p=np.array([[0, 1e30], [0, 0], [1e30, 0], [1e30, 0]], np.float32),
    )
    for network in (np.zeros(N_NUMBERS), *random_networks(1)):
        g = weigh(network, seen)
        assert np.all((g >= 0.0) & (g <= 1.0))


BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62, "task.duration": 60.0}
SCENARIOS = {name: find_scenario(name, BUSY) for name in ("es1", "real")}
SEEDS = 10_000, 10_001


def trips_of(networks, seeds, workers=1):
    rollouts = CandidateRollouts(
        SCENARIOS, find_controller("ssgiff"), "kinematic", JoblibBackend(workers)
    )
    return rollouts.round_trips(networks, seeds)


@pytest.fixture(scope="module")
def alone():
    """Round trips of two very different candidates, each by itself in each world."""
    networks = 3.0 * random_networks(2)
    found = [[trips_of(each[None], (seed,)) for seed in SEEDS] for each in networks]
    return networks, {
        name: np.array([[one[name][0, 0] for one in row] for row in found]) for name in SCENARIOS
    }


@pytest.mark.parametrize("workers", [1, 2])
def test_candidates_side_by_side_have_the_round_trips_they_have_alone(alone, workers):
    networks, expected = alone
    found = trips_of(networks, SEEDS, workers)
    for name in SCENARIOS:
        np.testing.assert_array_equal(found[name], expected[name])
    assert len(np.unique(found["es1"])) > 1


def test_another_policy_under_the_same_name_is_another_configuration(policy_file):
    controller = dataclasses.replace(
        find_controller("ssgiff"), weighting=LearnedWeighting(policy=str(policy_file))
    )
    first = ExperimentConfig("x", find_scenario("es1"), controller).key
    policy = load_policy(policy_file)
    save_policy(policy_file, {k: 2.0 * w for k, w in policy.weights.items()}, policy.card)
    assert ExperimentConfig("x", find_scenario("es1"), controller).key != first
