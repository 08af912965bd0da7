"""How the worlds of many candidates are shared out, and how a motion is copied, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training import candidate_rollouts
from training.candidate_rollouts import CandidateRollouts


def rollouts(workers=2, device="cpu", **scenarios):
    found = scenarios or {"es1": find_scenario("es1", {"n_robots": 5, "duration": 60.0})}
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
        (job.controllers[k].weighting.network[0], job.seeds[k])
        for job in jobs for k in range(len(job.seeds))
    ]  # fmt: skip
    assert worlds == [
        (2.0 * network, seed) for network in range(n_networks) for seed in range(10, 10 + n_seeds)
    ]


def test_swarms_of_more_robots_than_a_job_run_one_by_one(monkeypatch):
    monkeypatch.setattr(candidate_rollouts, "MAX_ROWS", 4)
    assert [len(job.seeds) for job in jobs_of(rollouts(1), 1, range(3))] == [1, 1, 1]


def test_the_simulated_time_is_that_of_all_worlds_of_all_scenarios():
    made = rollouts(
        one=find_scenario("es1", {"duration": 60.0}),
        two=find_scenario("es1", {"duration": 90.0, "tick": 0.5}),
    )
    assert made.simulated_s(4) == pytest.approx(4 * 150.0)


@pytest.mark.parametrize(("device", "by_backend"), [("cpu", 2), ("cuda", 0)])
def test_a_backend_runs_the_jobs_of_a_cpu_only(monkeypatch, device, by_backend):
    given = []
    monkeypatch.setattr(candidate_rollouts, "run_job", lambda job: np.array(job.seeds))
    monkeypatch.setattr(
        candidate_rollouts, "run_in_order",
        lambda backend, run, jobs: given.extend(jobs) or map(run, jobs),
    )  # fmt: skip
    found = rollouts(2, device).round_trips(np.ones((1, 2), np.float32), [4, 5])
    assert found["es1"].tolist() == [[4, 5]]
    assert len(given) == by_backend
