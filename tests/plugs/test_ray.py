"""The Ray backend, on clusters of two or three nodes of this machine; run by `make test-ray`."""

import hashlib
import os
import signal
import time
import uuid
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from contextlib import closing
from functools import partial

import numpy as np
import pytest

from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.runner import Plan, evaluate
from baselines.evaluation.trajectories import Trajectories
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from tests.processes import becomes_true

pytestmark = [
    pytest.mark.ray,
    pytest.mark.filterwarnings("ignore"),  # ray warns about itself
]

SEEDS = range(8)


@pytest.fixture(scope="module")
def cluster():
    """A cluster of this machine: a first node without CPU, and two nodes with one each."""
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    for _ in range(2):
        made.add_node(num_cpus=1)
    yield made
    ray.shutdown()
    made.shutdown()


@pytest.fixture
def backend(cluster):
    from baselines.evaluation.ray_backend import RayBackend

    return RayBackend(2, address=cluster.address)


def plan_of(folder, duration=30.0, trajectories=False):
    scenario = find_scenario("es1", {"task.duration": duration})
    dataset = Dataset(folder)
    dataset.open()
    configurations = [
        ExperimentConfig(name, scenario, find_layered_controller(name), "kinematic")
        for name in ("nc", "ssgikf")
    ]
    kept = Trajectories(dataset) if trajectories else None
    return Plan(configurations, SEEDS, dataset, kept)


def hashes(folder):
    """The hash of every file of a dataset without the time that its episode took, by its name."""
    import pyarrow.parquet as pq

    return {
        file.relative_to(folder): hashlib.sha256(
            repr(pq.read_table(file).drop_columns("wall_s").to_pylist()).encode()
        ).hexdigest()
        for file in folder.rglob("*.parquet")
    }


@pytest.fixture
def expected(tmp_path):
    """The hashes of the dataset that one process makes."""
    plan = plan_of(tmp_path / "alone")
    evaluate(plan.configurations, SEEDS, plan.dataset)
    return hashes(tmp_path / "alone")


def test_trajectories_are_kept_here_too(backend, tmp_path):
    for name, runs_on in (("alone", JoblibBackend()), ("ray", backend)):
        assert sum(plan_of(tmp_path / name, 5.0, trajectories=True).run(runs_on)) == 16
    alone, spread = (
        {file.relative_to(folder): file.read_bytes() for file in folder.rglob("*.parquet")}
        for folder in (tmp_path / "alone-trajectories", tmp_path / "ray-trajectories")
    )
    assert spread == alone
    assert len(alone) == 16


def die_once(job):
    """Kills its worker at the first call, and leaves a trace."""
    file, number = job
    if number == 1 and not file.exists():
        file.write_text("")
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_a_worker_that_dies_is_replaced(backend, tmp_path):
    jobs = [(tmp_path / "died", number) for number in range(4)]
    assert sorted(backend.run(die_once, jobs)) == [0, 1, 2, 3]
    assert (tmp_path / "died").exists()


def die(_):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_call_that_always_kills_its_worker_ends_the_run(backend, monkeypatch):
    monkeypatch.setattr("baselines.evaluation.ray_backend.MAX_RETRIES", 1)
    with pytest.raises(BrokenExecutor):
        list(backend.run(die, [0]))


def complain(number):
    raise ConfigError(f"number={number}: must be another")


def test_what_a_call_raises_is_raised_here(backend):
    with pytest.raises(ConfigError, match=r"^number=7: must be another$"):
        list(backend.run(complain, [7]))


def test_a_node_with_other_code_is_refused(backend, monkeypatch):
    monkeypatch.setattr("baselines.evaluation.ray_backend.code_here", lambda: "other")
    with pytest.raises(ConfigError, match="has another swarm-forage, numba, numpy, pymunk or Pyt"):
        list(backend.run(abs, [0]))


def test_calls_that_run_are_ended_with_the_iterator(backend, tmp_path):
    """The backend leaves the cluster; a program that has joined it by itself stays there."""
    import ray

    with closing(backend.run(nap_after, [(tmp_path / str(k), k) for k in range(2)])) as finished:
        assert next(finished) == 0
        assert becomes_true((tmp_path / "1").exists, 60.0)
    assert not ray.is_initialized()
    ray.init(backend.address, log_to_driver=False)
    with closing(backend.run(abs, [1, 2, 3])) as finished:
        assert next(finished)
    n_free, n_all = ray.available_resources, ray.cluster_resources
    assert becomes_true(lambda: n_free().get("CPU") == n_all()["CPU"], 60.0)


def nap_after(job):
    file, number = job
    file.write_text("")
    time.sleep(100.0 * number)
    return number


def test_an_address_where_nobody_answers_is_refused_at_once(monkeypatch):
    from baselines.evaluation.ray_backend import RayBackend

    monkeypatch.setattr("ray.is_initialized", lambda: False)
    begin = time.monotonic()
    for address in ("127.0.0.1:9", "127.0.0.1:port"):
        with pytest.raises(ConfigError, match=f"--address={address}: no Ray cluster answers"):
            RayBackend(address=address).connect()
    assert time.monotonic() - begin < 20.0


def test_candidates_of_cma_make_the_same_round_trips(backend):
    from training.candidate_rollouts import CandidateRollouts
    from training.cma_es import initial_mean

    scenarios = {"es1": find_scenario("es1", {"task.duration": 600.0})}
    controller = find_controller("ssgiff")
    two = np.stack([initial_mean(seed, "weighting") for seed in range(2)]).astype(np.float32)
    here = CandidateRollouts(scenarios, controller, "kinematic")
    there = CandidateRollouts(scenarios, controller, "kinematic", backend)
    expected = here.round_trips(two, range(6))["es1"]
    np.testing.assert_array_equal(there.round_trips(two, range(6))["es1"], expected)
    assert expected.any()


def held(function, folder, job):
    """A call that leaves a trace of its node, and waits until it may go on."""
    import ray

    (folder / f"{uuid.uuid4()}.at").write_text(ray.get_runtime_context().get_node_id())
    while not (folder / "go").exists():
        time.sleep(0.05)
    return function(job)


def test_a_node_that_dies_in_mid_run_loses_and_repeats_nothing(
    cluster, expected, tmp_path, monkeypatch, capsys
):
    """Three nodes, all of them at work when one is killed; the others do its part."""
    from baselines.evaluation.ray_backend import RayBackend

    class Held(RayBackend):
        def run(self, function, jobs):
            return super().run(partial(held, function, tmp_path), jobs)

    def kill_one():
        try:
            assert becomes_true(lambda: len(list(tmp_path.glob("*.at"))) == 3, 60.0)
            at_work = {trace.read_text() for trace in tmp_path.glob("*.at")}
            node = next(each for each in cluster.worker_nodes if each.node_id in at_work)
            cluster.remove_node(node, allow_graceful=False)
        finally:
            (tmp_path / "go").write_text("")

    cluster.add_node(num_cpus=1)
    plan, kept, keep = plan_of(tmp_path / "ray"), [], Dataset.keep
    monkeypatch.setattr(Dataset, "keep", lambda *given: (kept.extend(given[2]), keep(*given)))
    blocks = plan.blocks(JoblibBackend(3))
    with ThreadPoolExecutor(1) as pool:
        killed = pool.submit(kill_one)
        assert sum(plan.run(Held(3, address=cluster.address))) == len(kept) == 16
        killed.result()
    assert len(list(tmp_path.glob("*.at"))) == len(blocks) + 1, "one block was run again"
    assert hashes(tmp_path / "ray") == expected
    assert capsys.readouterr().out == "", "stdout is for results"
