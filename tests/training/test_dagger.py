"""DAgger: it learns from the true errors of estimates, and survives being killed."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from baselines.evaluation.episode import run_episodes
from baselines.oracles.oracle import errors
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from training import dagger
from training.dagger import HIDDEN, DAggerTraining, WeightingActor, train
from training.exchanges import UNKNOWN_ERROR, Exchanges, error_of_copying, record_exchanges
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    REPUTATION_NETWORK,
    LearnedReputation,
    LearnedWeighting,
    flatten,
)
from training.policy_file import load_policy, observation_layout

BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62, "task.duration": 120.0}
SCENARIO = find_scenario("es1", BUSY)
LAYOUT = observation_layout("weighting", SCENARIO)
SEEDS = 10_000, 10_001, 10_002


pytestmark = pytest.mark.usefixtures("elsewhere")


@pytest.fixture
def imitating(experiment):
    """Make an experiment that imitates."""

    def make(**changes):
        terms = {"algorithm": "imitation", "population": None, "worlds": 3, "budget": 2, "every": 1}
        return experiment(**terms | changes)

    return make


def test_the_error_of_copying_an_unknown_place_by_hand():
    g, c = torch.tensor([0.0, 1.0, 0.5]), UNKNOWN_ERROR
    heard = torch.tensor([[0.1, 0.0], [0.1, 0.0], [3.0, 0.0]])
    expected = [c, 0.01, 0.5 * c + 0.5 * 0.5]
    np.testing.assert_allclose(error_of_copying(g, heard), expected, atol=1e-7)


def test_a_fit_finds_out_who_is_right(imitating):
    # the heard place is right if it was reached lately, and else the own one is
    rng, rows = np.random.default_rng(0), 4000
    seen = {name: k for k, name in enumerate(LAYOUT.names)}
    observed = np.zeros((rows, len(LAYOUT)), np.float32)
    heard_p = rng.uniform(0.0, 2.0, rows).astype(np.float32)
    shown = {"own_p": 1.0, "own_known": 1.0, "heard_p": heard_p, "heard_known": 1.0}
    for name, value in shown.items():
        observed[:, seen[f"encounter.{name}.prey"]] = value
    observed[:, seen["encounter.frames"]] = 8.0
    wrong, right = rng.normal(0.0, 0.2, (rows, 2)), np.zeros((rows, 2))
    fresh = (heard_p < 1.0)[:, None]
    area = np.tile(np.array([0.0, 1.0], np.float32), (rows, 1))
    errors = [each.astype(np.float32) for each in (np.where(fresh, wrong, right),
                                                   np.where(fresh, right, wrong))]  # fmt: skip
    learning = DAggerTraining(imitating())
    known = np.ones(rows, np.float32)
    shares = learning._fit({"es1": Exchanges(observed, area, known, *errors)})
    assert shares["es1"] > 0.95


def test_training_ends_with_the_best_policy_as_a_controller(imitating, monkeypatch):
    mine = imitating(controller="dsgiff-frequent")
    lines, rates, adam = [], [], torch.optim.Adam
    monkeypatch.setattr(
        torch.optim, "Adam", lambda numbers, lr: rates.append(lr) or adam(numbers, lr)
    )
    torch.set_num_threads(2)
    policy = train(mine, lines.append)
    assert torch.get_num_threads() == 1, "so that sums are the same whatever the workers"
    assert rates == [dagger.LEARNING_RATE, dagger.LEARNING_RATE / 2], "of two rounds"
    assert any("gain per exchange as a share of the oracle's: es1 " in line for line in lines)
    curve = policy.card.curve
    assert [point.step for point in curve] == [0, 1, 2]
    assert [point.simulated_s for point in curve] == [0.0, 180.0, 360.0]  # 3 worlds of 60 s
    best = max(curve, key=lambda point: point.value)
    assert policy.card.score == best.round_trips
    assert policy.card.layers["weighting"].sizes == {"hidden": HIDDEN}
    assert EXCHANGE_NETWORK.numbers_of(policy).size == 170
    controller = find_controller(f"learned-weighting:policy={policy.source}")
    scenario = mine.scenarios_by_name["es1"]
    episodes = run_episodes(scenario, controller, mine.held_back_seeds, "kinematic")
    assert np.mean([each.round_trips for each in episodes]) == policy.card.score["es1"].mean
    assert list((mine.out / "tensorboard").iterdir())


@pytest.mark.parametrize("name", ["weighting", "mine"])
def test_a_fit_goes_on_from_a_learned_weighting(imitating, name, policy_file):
    policy = load_policy({"weighting": "weighting", "mine": policy_file}[name])
    mine = imitating(controller=f"learned-weighting:policy={policy.source}")
    actor = DAggerTraining(mine)._actor
    shapes = EXCHANGE_NETWORK.shapes(actor.sizes)
    np.testing.assert_array_equal(
        flatten(actor.to_numpy(), shapes), EXCHANGE_NETWORK.numbers_of(policy)
    )


AMONG_LIARS = "reputation_odometry+sgikf+subsumption:weighs_unknown=true,pause=5"
LIARS = {"faults.liar.share": 0.3, "faults.liar.shift": 0.4}
AS_TEXT = {name: str(value) for name, value in {**BUSY, **LIARS}.items()}


@pytest.mark.parametrize(
    ("name", "network", "rule"),
    [
        (AMONG_LIARS, REPUTATION_NETWORK, LearnedReputation),
        ("dsgiff-frequent", EXCHANGE_NETWORK, LearnedWeighting),
        ("ssgiff", EXCHANGE_NETWORK, LearnedWeighting),
    ],
)
def test_the_network_that_is_trained_is_the_one_that_runs(
    imitating, monkeypatch, name, network, rule
):
    monkeypatch.setattr(dagger, "GRADIENT_STEPS", 20)
    policy = train(imitating(budget=1, controller=name, settings=AS_TEXT), str)
    assert policy.card.layers["weighting"].network == network.name
    actor = WeightingActor(LAYOUT, HIDDEN, network)
    shapes = network.shapes(actor.sizes)
    actor.load_numpy(policy.weights_of("weighting", shapes))
    scenario = find_scenario("es1", {**BUSY, **LIARS, "task.duration": 480.0})
    controller = find_controller(name)
    numbers = flatten(actor.to_numpy(), shapes).astype(np.float32)
    found = record_exchanges(scenario, controller, numbers, SEEDS[:1], "kinematic")
    with torch.no_grad():
        g = (actor(torch.from_numpy(found.observed)) * torch.from_numpy(found.area)).sum(1)
    given = replace(controller, weighting=rule(policy=str(policy.source)))
    loop, columns = Loop(scenario, given, SEEDS[:1], "kinematic"), []
    exchanges = loop.controller.minds["estimator"]["exchange"][0]
    for _ in range(scenario.n_ticks):
        seen, (own, heard) = exchanges.copy(), errors(loop.controller.minds, loop.world)
        loop.step()
        mask = (seen["is_valid"][:, None] > 0) & (seen["heard_known"] > 0)
        is_known, needs_upload = seen["own_known"] > 0, seen["goal"][:, :2] > 0.0
        mask &= is_known if network is EXCHANGE_NETWORK else ~is_known | needs_upload
        mask &= needs_upload | (name == "dsgiff-frequent") | ~is_known
        columns.append((exchanges["weight"][mask], is_known[mask], own[mask], heard[mask]))
    weights, known, own, heard = map(np.concatenate, zip(*columns, strict=True))
    assert len(weights) > 15
    assert known.all() == (network is EXCHANGE_NETWORK)
    np.testing.assert_allclose(weights, g.numpy(), atol=1e-5)
    np.testing.assert_array_equal(found.known, known)
    np.testing.assert_allclose(found.own_error, own, atol=1e-5)
    np.testing.assert_allclose(found.heard_error, heard, atol=1e-5)


def test_a_training_stopped_anywhere_and_started_again_ends_the_same(
    imitating, monkeypatch, broken_anywhere
):
    monkeypatch.setattr(dagger, "GRADIENT_STEPS", 20)
    mine = imitating(every=2)
    broken_anywhere(train, mine, (DAggerTraining, "_save"), range(1, 5))
