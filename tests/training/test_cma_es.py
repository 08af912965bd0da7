"""CMA-ES climbs, keeps what held-back worlds judge best, survives kills; its candidates' worlds."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from training import candidate_rollouts, cma_es
from training.candidate_rollouts import CandidateRollouts
from training.checkpoint import CHECKPOINT, write_checkpoint
from training.cma_es import (
    ARCHITECTURES,
    CMAESTraining,
    fitness_of,
    initial_mean,
    initial_network,
    train,
)
from training.learned_weighting import EXCHANGE_NETWORK, HIDDEN
from training.policy_file import load_policy

pytestmark = pytest.mark.usefixtures("elsewhere")


def imagined_trips(number, seeds):
    return 1000.0 * np.exp(-((number - 1.0) ** 2)) + np.sin(seeds)


@pytest.fixture
def _imagined(monkeypatch):
    """Round trips of a seed and a network's last number alone, best at 1; no world runs."""

    def round_trips(self, networks, seeds):
        trips = imagined_trips(networks[:, -1].astype(np.float64)[:, None], np.array(seeds))
        return dict.fromkeys(self.scenarios, trips)

    monkeypatch.setattr(CandidateRollouts, "round_trips", round_trips)


@pytest.mark.usefixtures("_imagined")
def test_the_search_climbs(experiment):
    policy = train(experiment(budget=40, population=10, every=20), str)
    first, *_, last = policy.card.curve
    assert first.value < last.value
    assert EXCHANGE_NETWORK.numbers_of(policy)[-1] == pytest.approx(1.0, abs=0.2)


def test_every_generation_has_worlds_and_random_numbers_of_its_own(experiment, monkeypatch):
    worlds, drawn = [], []
    reseed = cma_es.CMA.reseed_rng

    def noted(self, seed):
        drawn.append(seed)
        reseed(self, seed)

    def round_trips(self, networks, seeds):
        if len(networks) > 1:
            worlds.append(tuple(seeds))
        return dict.fromkeys(self.scenarios, np.ones((len(networks), len(seeds))))

    monkeypatch.setattr(cma_es.CMA, "reseed_rng", noted)
    monkeypatch.setattr(CandidateRollouts, "round_trips", round_trips)
    train(experiment(budget=4, population=4, every=4, out=Path("one")), str)
    train(experiment(budget=4, population=4, every=4, out=Path("other"), seed=1), str)
    met = [seed for each in worlds for seed in each]
    assert len(worlds) == len(drawn) == 8
    assert len(set(met)) == len(met), "no two generations of any training share a world"
    assert len(set(drawn)) == 8


def test_a_checkpoint_whose_arrays_do_not_fit_is_refused(experiment):
    mine, n = experiment(), len(initial_mean(0, "weighting"))
    mine.out.mkdir(parents=True)
    kept = {"populations": np.zeros((2, 4, n), np.float32), "losses": np.zeros((2, 4))}
    for name in kept:
        odd = {**kept, name: np.concatenate([kept[name], kept[name][:1]])}
        write_checkpoint(mine.out / CHECKPOINT, mine.identity, [], odd)
        with pytest.raises(ConfigError, match="its arrays do not fit"):
            CMAESTraining(mine)


def test_the_search_starts_from_the_hand_written_rule(experiment):
    mine = experiment()
    rollouts = CandidateRollouts(mine.scenarios_by_name, mine.base_controller, mine.physics)
    start = initial_mean(0, "weighting")[None].astype(np.float32)
    rule = np.zeros_like(start)
    rule[0, -2] = 0.001 / 0.01 - 1.0  # as ssgiff:beta=0.001
    seeds = mine.held_back_seeds
    found, expected = rollouts.round_trips(start, seeds), rollouts.round_trips(rule, seeds)
    np.testing.assert_array_equal(found["es1"], expected["es1"])
    assert (start != rule).any()
    assert not initial_mean(0, "motion").any()


@pytest.mark.parametrize(("layer", "network"), ARCHITECTURES.items())
def test_the_search_goes_on_from_a_learned_layer(experiment, layer, network):
    mine = experiment(layer=layer, controller="learned-both", budget=1, every=1)
    shipped = network.numbers_of(load_policy(mine.base_controller.layers[layer].policy))
    _, start = initial_network(mine, layer)
    np.testing.assert_array_equal(start, shipped)
    policy = train(mine, str)
    assert policy.card.curve[0].step == 0
    assert network.numbers_of(policy).shape == shipped.shape


@pytest.mark.usefixtures("_imagined")
def test_a_search_stopped_anywhere_and_started_again_ends_the_same(experiment, broken_anywhere):
    mine = experiment(budget=3, every=2)
    policy = broken_anywhere(train, mine, (CMAESTraining, "_save"), range(1, 6))
    assert len(policy.card.curve) == 3


@pytest.mark.usefixtures("_imagined")
def test_the_folder_of_another_experiment_is_refused(experiment):
    train(experiment(budget=1), str)
    with pytest.raises(ConfigError, match=r"ssgiff motion.mean_run = 0.33, not 1.0"):
        train(experiment(budget=1, controller="ssgiff:mean_run=1"), str)


def test_the_value_is_the_mean_logarithm_over_the_scenarios():
    trips = {"a": np.array([[9, 9], [0, 0]]), "b": np.array([[98, 100], [0, 0]])}
    expected = [(np.log(10.0) + np.log(100.0)) / 2.0, 0.0]
    np.testing.assert_allclose(fitness_of(trips), expected)


@pytest.mark.parametrize(("layer", "sigma"), [("weighting", 0.3), ("motion", 0.05)])
def test_the_first_candidates_lie_around_the_start_as_widely_as_documented(
    experiment, monkeypatch, layer, sigma
):
    monkeypatch.setattr(CandidateRollouts, "warm_up", lambda self, network: None)
    search = cma_es.CMAESTraining(experiment(layer=layer))._search
    search.reseed_rng(0)
    away = np.array([search.ask() for _ in range(400)]) - initial_mean(0, layer)
    assert np.std(away) == pytest.approx(sigma, rel=0.05)


def test_hidden_units_begin_as_large_as_their_number_of_inputs_allows():
    shape = EXCHANGE_NETWORK.shapes({"hidden": HIDDEN})["hidden.weight"]
    start, count = initial_mean(5, "weighting"), shape[0] * shape[1]
    drawn = np.random.default_rng(5).normal(0.0, 1.0, count)
    np.testing.assert_allclose(start[:count] * np.sqrt(shape[1]), drawn)
    assert start[count:].tolist() == pytest.approx([0.0] * (len(start) - count - 2) + [-0.9, 0.0])


@pytest.mark.usefixtures("_imagined")
def test_a_curve_tells_the_time_that_all_candidates_were_simulated(experiment):
    scenarios = "es1:task.duration=60", "es1:task.duration=90,tick=0.2"
    mine = experiment(budget=2, every=1, worlds=3, scenarios=scenarios)
    # Worlds of 60 s and of 90 s: 3 of each for each of 4 candidates in each generation.
    assert [point.simulated_s for point in train(mine, str).card.curve] == [0.0, 1800.0, 3600.0]


def rollouts(workers=2, device="cpu"):
    found = {"es1": find_scenario("es1", {"n_robots": 5, "duration": 60.0})}
    backend = SimpleNamespace(workers=workers)
    return CandidateRollouts(found, find_controller("ssgiff"), backend=backend, device=device)


def jobs_of(made, n_networks, seeds):
    scenario = next(iter(made.scenarios.values()))
    networks = np.arange(2.0 * n_networks, dtype=np.float32).reshape(n_networks, 2)
    return list(made._jobs(scenario, networks, seeds))


@pytest.mark.parametrize(
    ("workers", "n_networks", "n_seeds", "sizes", "device"),
    [
        (1, 2, 3, [6], "cpu"),
        (4, 2, 3, [2, 2, 2], "cpu"),
        (2, 3, 3, [5, 4], "cpu"),
        (2, 40, 20, [400, 400], "cpu"),  # 400 worlds of 5 robots are the most of a job
        (1, 41, 20, [274, 273, 273], "cpu"),
        (2, 41, 20, [820], "cuda"),  # all of a scenario at once
    ],
)
def test_worlds_are_shared_out_among_workers_in_jobs_of_two_thousand_robots(
    workers, n_networks, n_seeds, sizes, device
):
    jobs = jobs_of(rollouts(workers, device), n_networks, range(10, 10 + n_seeds))
    assert [len(job.seeds) for job in jobs] == sizes
    worlds = [
        (job.controllers[k].weighting.weights[0], job.seeds[k])
        for job in jobs for k in range(len(job.seeds))
    ]  # fmt: skip
    assert worlds == [
        (2.0 * network, seed) for network in range(n_networks) for seed in range(10, 10 + n_seeds)
    ]


def test_swarms_of_more_robots_than_a_job_run_one_by_one(monkeypatch):
    monkeypatch.setattr(candidate_rollouts, "MAX_ROWS", 4)
    assert [len(job.seeds) for job in jobs_of(rollouts(1), 1, range(3))] == [1, 1, 1]


@pytest.mark.parametrize(("device", "by_backend"), [("cpu", 2), ("cuda", 0)])
def test_a_backend_runs_the_jobs_of_a_cpu_only(monkeypatch, device, by_backend):
    given = []

    def run_job(job):
        firsts = [each.weighting.weights[0] for each in job.controllers]
        return np.add(firsts, job.seeds)

    monkeypatch.setattr(candidate_rollouts, "run_job", run_job)
    monkeypatch.setattr(
        candidate_rollouts, "run_in_order",
        lambda backend, run, jobs: given.extend(jobs) or map(run, jobs),
    )  # fmt: skip
    found = rollouts(2, device).round_trips(np.array([[10, 0], [20, 0]], np.float32), [4, 5, 6])
    assert found["es1"].tolist() == [[14, 15, 16], [24, 25, 26]]
    assert len(given) == by_backend
