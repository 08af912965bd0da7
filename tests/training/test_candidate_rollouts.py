"""How the worlds of many candidates are shared out, and how a motion is copied, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training import candidate_rollouts, ppo
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
    ("workers", "n_networks", "n_seeds", "sizes"),
    [
        (1, 2, 3, [6]),
        (2, 2, 3, [3, 3]),
        (4, 2, 3, [2, 2, 2]),
        (2, 3, 3, [5, 4]),
        (2, 40, 20, [400, 400]),  # 400 worlds of 5 robots are the most of a job
        (1, 41, 20, [274, 273, 273]),
    ],
)
def test_worlds_are_shared_out_among_workers_in_jobs_of_two_thousand_robots(
    workers, n_networks, n_seeds, sizes
):
    jobs = jobs_of(rollouts(workers), n_networks, range(10, 10 + n_seeds))
    assert [len(job.seeds) for job in jobs] == sizes
    worlds = [
        (job.controllers[k].weighting.network[0], job.seeds[k])
        for job in jobs for k in range(len(job.seeds))
    ]  # fmt: skip
    assert worlds == [
        (2.0 * network, seed) for network in range(n_networks) for seed in range(10, 10 + n_seeds)
    ]


def test_a_gpu_runs_all_worlds_of_a_scenario_at_once():
    assert [len(job.seeds) for job in jobs_of(rollouts(2, "cuda"), 41, range(20))] == [820]


def test_swarms_of_more_robots_than_a_job_run_one_by_one(monkeypatch):
    monkeypatch.setattr(candidate_rollouts, "MAX_ROWS", 4)
    assert [len(job.seeds) for job in jobs_of(rollouts(1), 1, range(3))] == [1, 1, 1]


def test_round_trips_come_back_by_scenario_candidate_and_seed(monkeypatch):
    made = rollouts(
        2, one=find_scenario("es1", {"n_robots": 5}), two=find_scenario("es1", {"n_robots": 7})
    )

    def ran(job):
        n, worlds = job.scenario.task.n_robots, zip(job.controllers, job.seeds, strict=True)
        trips = [10 * int(each.weighting.network[0]) + seed for each, seed in worlds]
        return 1000 * n + np.array(trips)

    monkeypatch.setattr(candidate_rollouts, "run_job", ran)
    monkeypatch.setattr(
        candidate_rollouts, "run_in_order", lambda backend, run, jobs: map(run, jobs)
    )
    networks = np.array([[1.0], [2.0], [3.0]], np.float32)
    found = made.round_trips(networks, [4, 5])
    assert {name: trips.tolist() for name, trips in found.items()} == {
        "one": [[5014, 5015], [5024, 5025], [5034, 5035]],
        "two": [[7014, 7015], [7024, 7025], [7034, 7035]],
    }


def test_the_simulated_time_is_that_of_all_worlds_of_all_scenarios():
    made = rollouts(
        one=find_scenario("es1", {"duration": 60.0}),
        two=find_scenario("es1", {"duration": 90.0, "tick": 0.5}),
    )
    assert made.simulated_s(4) == pytest.approx(4 * 150.0)


class Line(torch.nn.Module):
    """A network of one weight, and what it was shown."""

    def __init__(self):
        super().__init__()
        self.weight = torch.nn.Parameter(torch.zeros(1))
        self.sizes = []

    def forward(self, observed):
        self.sizes.append(len(observed))
        return observed * self.weight, None


def test_a_copy_is_fitted_in_twenty_epochs_of_batches_of_512(monkeypatch):
    torch.manual_seed(0)
    observed, wheels = np.ones((600, 2), np.float32), np.full((600, 2), 0.5, np.float32)
    actor = Line()
    ppo.clone_behaviour(actor, [(observed[:400], wheels[:400]),
                                              (observed[400:], wheels[400:])])  # fmt: skip
    assert actor.sizes == [512, 88] * 20
    assert actor.weight.item() == pytest.approx(0.04, rel=0.01)  # 40 steps of Adam of 1e-3
    with monkeypatch.context() as patch:
        patch.setattr(ppo, "LEARNING_RATE", 0.0)
        patch.setattr(ppo, "BATCH_SIZE", 400)
        still = Line()
        half = ppo.clone_behaviour(
            still, [(observed[:300], wheels[:300]), (observed[:300], 0.0 * wheels[:300])]
        )
    assert still.sizes == [400, 200] * 20
    assert half == pytest.approx(0.125)  # the mean of 0.25 and 0


def test_every_scenario_is_compiled_before_workers_start(monkeypatch):
    stepped = []

    class OneStep:
        def __init__(self, scenario, controller, seeds, physics):
            self.name = scenario.task.n_robots, controller.weighting.network[0], physics

        def step(self):
            stepped.append(self.name)

    monkeypatch.setattr(candidate_rollouts, "Loop", OneStep)
    two = {f"n{n}": find_scenario("es1", {"n_robots": n}) for n in (5, 7)}
    rollouts(**two).warm_up(np.array([0.5], np.float32))
    assert stepped == [(5, 0.5, "rigid"), (7, 0.5, "rigid")]
    monkeypatch.setattr(candidate_rollouts, "DeviceLoop", lambda loop: SimpleNamespace(
        step=lambda: stepped.append("on a GPU")))  # fmt: skip
    stepped.clear()
    rollouts(device="cuda", **two).warm_up(np.array([0.5], np.float32))
    assert stepped == ["on a GPU"] * 2


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


def test_an_episode_on_a_gpu_has_all_its_ticks_and_is_checked(monkeypatch):
    done = []
    monkeypatch.setattr(
        candidate_rollouts, "Loop", type("Loop", (), {"__new__": lambda *_: "worlds"})
    )
    monkeypatch.setattr(candidate_rollouts, "DeviceLoop", lambda loop: SimpleNamespace(
        run=done.append, check=lambda: done.append("check"),
        download=lambda: (loop, "at the end")))  # fmt: skip
    job = SimpleNamespace(scenario=SimpleNamespace(n_ticks=230), controllers=(), seeds=(),
                          physics="kinematic", device="cuda")  # fmt: skip
    assert candidate_rollouts.after_episode(job) == ("worlds", "at the end")
    assert done == [100, 100, 30, "check"]


def test_a_demonstration_is_what_is_seen_before_a_step_and_done_in_it():
    command = np.zeros((1, 1), [("command", [("wheels", np.float32, 2)])])
    world = SimpleNamespace(robots=command, scenario=SimpleNamespace(n_ticks=61))

    def step():
        command["command"]["wheels"] += 1

    def read(fields, robots, out):
        out[:] = command["command"]["wheels"][:, :, :1]

    loop = SimpleNamespace(
        world=world,
        step=step,
        kernel=lambda template, functions: read,
        fields=lambda layout: layout,
    )
    observed, wheels = ppo.record_demonstrations(loop, ["wheels.left"])
    assert observed.ravel().tolist() == [0.0, 20.0, 40.0, 60.0]  # every twentieth tick
    assert wheels[:, 0].tolist() == [1.0, 21.0, 41.0, 61.0]
