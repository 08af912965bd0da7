"""From configurations and seeds to episodes: each once, the same however they are spread."""

from dataclasses import replace

import pyarrow.parquet as pq
import pytest

from baselines.evaluation import runner
from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.dataset_reader import read_groups
from baselines.evaluation.runner import MAX_ROWS, Plan, evaluate, run_with_progress
from swarm_forage_env import compiler
from swarm_forage_env.foraging import metrics
from swarm_forage_env.loop import Loop
from tests.evaluation.conftest import timeless


@pytest.fixture
def refuse_to_run(monkeypatch):
    """From now on every episode must be found."""

    def refuse(*_):
        raise AssertionError("nothing is left to run")

    return lambda: monkeypatch.setattr("baselines.evaluation.runner._run_block", refuse)


@pytest.mark.parametrize("workers", [1, 2])
def test_the_number_of_workers_changes_nothing_and_results_are_in_the_order_asked_for(
    configure, new_dataset, workers
):
    configurations = [configure("nc"), configure("ssgikf")]
    seeds = [7, 3, 5, 2**40]
    alone = evaluate(configurations, seeds, new_dataset("alone"))
    spread = evaluate(configurations, seeds, new_dataset("spread"), JoblibBackend(workers))
    assert timeless(spread) == timeless(alone)
    assert [(each.controller, each.seed) for each in spread] == [
        (name, seed) for name in ("nc", "ssgikf") for seed in seeds
    ]


def test_one_configuration_under_two_names_runs_once(configure, dataset, capsys):
    names = "ssgiff", "ssgiff:beta=0.01"
    plan = Plan([*map(configure, names)], range(2), dataset)
    run_with_progress(plan, JoblibBackend())
    assert "0 of 2 episodes found" in capsys.readouterr().err
    assert [each.controller for each in plan.results()] == [
        name for name in names for _ in range(2)
    ]


def test_what_is_kept_is_called_as_it_is_asked_for_now_and_stays_what_it_is(
    configure, dataset, refuse_to_run
):
    def kept():
        return [dataset.place(configure("ssgiff"), seed).read_bytes() for seed in range(2)]

    first = evaluate([configure("ssgiff")], range(2), dataset)
    before = kept()
    refuse_to_run()
    again = evaluate([configure("ssgiff:beta=0.01")], range(2), dataset)
    assert again == [replace(each, controller="ssgiff:beta=0.01") for each in first]
    assert [group.label() for group in read_groups([str(dataset.folder)])] == ["ssgiff:beta=0.01"]
    assert evaluate([configure("ssgiff")], range(2), dataset) == first
    assert kept() == before


def test_a_file_is_not_written_anew_under_the_name_it_has(configure, dataset, monkeypatch):
    for name in ("ssgiff:beta=0.02", "ssgiff"):
        evaluate([configure(name)], range(2), dataset)
        for file in dataset.folder.rglob("*.parquet"):
            pq.write_table(pq.ParquetFile(file).read().replace_schema_metadata(None), file)
    monkeypatch.setattr(dataset, "write", None)
    evaluate([configure("ssgiff:beta=0.02"), configure("ssgiff")], range(2), dataset)


@pytest.mark.parametrize(("robots", "episodes"), [(10, 90), (100, 7), (3, 1), (1000, 4)])
@pytest.mark.parametrize("workers", [1, 2, 8])
def test_blocks_hold_each_seed_once_and_leave_nobody_idle(
    configure, dataset, robots, episodes, workers
):
    arena = {"arena_length": 9.0, "arena_width": 9.0, "task_start_radius": 1.8}
    configuration = configure(task_n_robots=robots, task_area_distance=5.0, **arena)
    blocks = Plan([configuration], range(episodes), dataset).blocks(JoblibBackend(workers))
    assert sorted(seed for _, seeds in blocks for seed in seeds) == list(range(episodes))
    assert len(blocks) >= min(workers, episodes)
    sizes = {len(seeds) for _, seeds in blocks}
    assert all(size == 1 or size * robots <= MAX_ROWS for size in sizes)
    assert max(sizes) - min(sizes) <= 1


def test_what_is_compiled_is_told_for_which_controller(configure, dataset, monkeypatch):
    def compile_something(configuration, device):
        for tell in compiler._listeners:
            tell("tick")

    monkeypatch.setattr(runner, "warm_up", compile_something)
    messages, plan = [], Plan([configure("nc"), configure("ssgikf")], range(3), dataset)
    list(plan.run(JoblibBackend(), tell=messages.append))
    assert messages == ["compiling 1 of 2, nc: tick", "compiling 2 of 2, ssgikf: tick", ""]


def test_whatever_measures_an_episode_is_compiled_before_it_runs(configure, monkeypatch):
    used = set()
    kernel = lambda _, template, functions: lambda *arguments: used.add(template)  # noqa: E731
    monkeypatch.setattr(Loop, "kernel", kernel)
    runner.warm_up(configure(task_duration=1800.0))
    assert used == {metrics.add_errors, metrics.count_on_path}


def test_a_listener_is_told_of_an_entry_point_before_it_is_compiled(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(compiler, "announce", lambda: None)

    def twice_and_three(x):
        return 2 * x + 3

    messages = []
    compiled = compiler.entry_point(twice_and_three)
    with compiler.report_compiling(messages.append):
        compiled(1.0)
        compiled(2.0)
    assert messages == ["twice_and_three"]
    assert compiler._listeners == []


def test_on_a_terminal_the_bar_ends_full(configure, dataset, monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    run_with_progress(Plan([configure("nc")], range(3), dataset), JoblibBackend())
    assert "3/3" in capsys.readouterr().err
