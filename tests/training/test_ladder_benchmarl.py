"""The ladder's algorithms of BenchMARL; run by `make test-torchrl`."""

import importlib.util
from dataclasses import replace

import pytest

from training.ladder.benchmark import make
from training.ladder.rungs import read_algorithms, read_rungs
from training.ladder.runs import Job, add_run, find, read_runs

pytestmark = [
    pytest.mark.torchrl,
    pytest.mark.filterwarnings("ignore"),  # they warn about each other's versions
    pytest.mark.skipif(
        importlib.util.find_spec("benchmarl") is None, reason="run by `make test-torchrl`"
    ),
]

FEW = {
    f"{kind}_policy_{name}": number
    for kind in ("on", "off")
    for name, number in {"collected_frames_per_batch": 16, "n_envs_per_worker": 2}.items()
} | {
    "on_policy_minibatch_size": 8,
    "on_policy_n_minibatch_iters": 1,
    "off_policy_n_optimizer_steps": 1,
    "off_policy_train_batch_size": 8,
    "off_policy_memory_size": 100,
}

NAMES = [name for name, each in read_algorithms().items() if each.trainer == "benchmarl"]


@pytest.mark.parametrize("name", NAMES)
def test_an_algorithm_learns_on_a_rung_and_is_scored(name, tmp_path):
    rung = read_rungs()["near"]
    short = {**rung.keywords, "max_cycles": 8}
    card = rung.card.model_copy(update={"episodes": 2, "curve_episodes": 2})
    algorithm = read_algorithms()[name]
    small = algorithm.model_copy(update={"experiment": FEW})
    job = Job(replace(rung, keywords=short, card=card), small, 3, 32 * 5 * 10)
    run = make(job)
    add_run(run, tmp_path / "runs.parquet")
    assert [point["robot_steps"] for point in run.curve] == [800, 1600]
    assert len(run.scores) == 2
    assert find(job, read_runs(tmp_path / "runs.parquet")) == run
    assert run.versions["benchmarl"]


@pytest.mark.parametrize("name", ["ippo", "iql"])
def test_from_exchange_to_exchange_ticks_are_counted(name):
    rung = read_rungs()["weighting"]
    busy = {"task.area_distance": 0.7, "robot.cruise_speed": 0.12, "max_cycles": 600}
    card = rung.card.model_copy(update={"episodes": 2, "curve_episodes": 2})
    small = read_algorithms()[name].model_copy(update={"experiment": FEW})
    job = Job(replace(rung, keywords={**rung.keywords, **busy}, card=card), small, 3, 30_000)
    steps = [point["robot_steps"] for point in make(job).curve]
    assert steps == sorted(steps)
    assert steps[-2] < 30_000 <= steps[-1]
    assert all(each % 10 == 0 for each in steps)
    assert steps[0] > 16 * 10  # a decision is no tick
