"""The commands of the ladder, and the clock of a training on it; nothing trains."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from baselines.evaluation import figure_page
from swarm_forage_env.errors import ConfigError
from training.experiment import HELD_BACK_SEEDS
from training.ladder import benchmark, commands, figures, play, runs
from training.ladder.play import POINTS, Watch, robot_steps_of_a_decision
from training.ladder.rungs import DEFAULTS, Score, read_algorithms, read_rungs
from training.ladder.runs import Run

DOCS = Path(__file__).resolve().parents[2] / "docs"

TINY = {"scenario": "es1", "learn": "motion", "physics": "kinematic", "task.n_robots": 4,
        "task.duration": 20.0}  # fmt: skip


@pytest.fixture
def call(monkeypatch, tmp_path):
    """Run a command of the ladder, of which nothing is done: its result, and what it would do."""
    done = SimpleNamespace(jobs=[], workers=[])
    monkeypatch.setattr(commands, "find_backend", lambda *given, **_: done.workers.append(given[1]))
    monkeypatch.setattr(benchmark, "run_jobs", lambda jobs, *_: done.jobs.append(jobs))
    monkeypatch.setattr(benchmark, "score_references", lambda rung, out, backend: {})
    monkeypatch.chdir(tmp_path)

    def run(*words):
        return CliRunner().invoke(commands.benchmark, [*map(str, words)]), done

    return run


@pytest.fixture
def kept(tmp_path):
    """The option of a copy of the runs that the documentation tells of, and these."""
    file = tmp_path / "runs.parquet"
    file.write_bytes((DOCS / "data" / "ladder.parquet").read_bytes())
    return f"--out={file}", runs.read_runs(file)


def test_a_ladder_makes_five_trainings_of_all_algorithms_on_all_rungs(call, kept):
    result, done = call("ladder", kept[0])
    (jobs,), rungs, algorithms = done.jobs, read_rungs(), read_algorithms().values()
    assert len(jobs) == 5 * sum(len(each.rungs) or len(rungs) for each in algorithms)
    assert {job.seed for job in jobs} == {0, 1, 2, 3, 4}
    assert {job.budget for job in jobs} == {None}
    assert done.workers == [2]
    assert len(result.output.splitlines()) == len(kept[1])
    for run in kept[1]:
        told = f"{run.score:.1f}, {rungs[run.rung].normalised(run.score):.2f}"
        assert f"{run.rung} {run.algorithm} {run.seed}: {told}\n" in result.output


def test_a_ladder_of_one_rung_tells_of_that_and_keeps_a_file_of_all(call, kept, tmp_path):
    result, done = call(
        "ladder", "--rung=near", "--algorithm=sb3_ppo", "--seeds=1", "--budget=500",
        "--workers=3", kept[0],
    )  # fmt: skip
    ((job,),) = done.jobs
    told = job.rung.name, job.algorithm.name, job.seed, job.robot_steps
    assert told == ("near", "sb3_ppo", 0, 500)
    assert done.workers == [3]
    assert all(line.startswith("near sb3_ppo ") for line in result.output.splitlines())
    tree = json.loads((tmp_path / "runs" / "marl_eval.json").read_text("utf-8"))["swarm_forage"]
    assert set(tree) == {run.rung for run in kept[1]}


def test_the_defaults_are_trained_on_es1_and_shown_in_a_table(call, monkeypatch):
    curve = [{"robot_steps": 3_000_000, "wall_s": 30.0, "scores": [200.0]}]
    found = [
        Run("es1", name, 0, "key", {}, 6_000_000, 60.0, curve, (score,), (0.5 * score,), {})
        for name, score in (("sb3_ppo", 230.0), ("sb3_dqn", 120.0))
    ]
    monkeypatch.setattr(runs, "current", lambda *given: found)
    monkeypatch.setattr(benchmark, "installed", list)
    result, done = call("defaults", "--seeds=2")
    (jobs,) = done.jobs
    assert {(job.rung.name, job.seed) for job in jobs} == {("es1", 0), ("es1", 1)}
    assert {job.algorithm.name for job in jobs} == set(DEFAULTS)
    lines = [line for line in result.output.splitlines() if "230.0" in line or "120.0" in line]
    assert len(lines) == 2, result.output


def test_the_page_of_the_documentation_is_what_its_runs_make(call, kept, tmp_path, monkeypatch):
    """Scores, intervals and comparisons, in their order; a figure of each rung, and one of all."""
    drawn = []
    monkeypatch.setattr(figures, "curves", lambda rung, *rest: f"curves of {rung.name}")
    monkeypatch.setattr(figures, "profiles", lambda rungs, *rest: f"profiles of {len(rungs)}")
    monkeypatch.setattr(figure_page, "save_figure", lambda *given: drawn.append(given[:2]))
    told = kept[0], f"--page={tmp_path / 'page.md'}"
    assert call("ladder", "--seeds=0", *told)[0].exit_code == 0
    folder, names = tmp_path / "images" / "ladder", {run.rung for run in kept[1]}
    ran = [name for name in read_rungs() if name in names]
    assert drawn == [
        *((f"curves of {name}", folder / f"{name}.png") for name in ran),
        (f"profiles of {len(ran)}", folder / "profile.png"),
    ]
    expected = (DOCS / "ladder.md").read_text("utf-8")
    command = "--out=docs/data/ladder.parquet --page=docs/ladder.md"
    assert command in expected
    made = (tmp_path / "page.md").read_text("utf-8")
    assert made.replace(" ".join(told), command) == expected


def test_runs_of_other_settings_are_told_and_kept(call, kept, tmp_path, monkeypatch):
    messages, (first, *rest) = [], kept[1][:3]
    monkeypatch.setattr(commands, "say", messages.append)
    few = [replace(first, key="old"), replace(first, robot_steps=1), *rest]
    runs.write_runs(few, tmp_path / "runs.parquet")
    result, _ = call("ladder", "--seeds=0", kept[0])
    told = f"{first.rung}, {first.algorithm}, seed {first.seed} no longer counts"
    assert [told in line for line in messages] == [True]
    assert len(result.output.splitlines()) == 3
    assert runs.read_runs(tmp_path / "runs.parquet") == few


def test_cards_are_scored_all_or_only_those_without_scores(call, monkeypatch):
    scored = []

    def score(rung, out, backend):
        scored.append(rung.name)
        return {"nc": Score(mean=4.04)}

    monkeypatch.setattr(benchmark, "score_references", score)
    result, done = call("cards", "--workers=4")
    assert scored == list(read_rungs())
    assert result.output.splitlines() == [f"{name} nc: 4.0" for name in read_rungs()]
    scored.clear()
    assert call("cards", "--missing")[0].output == ""
    assert done.workers == [4, 2]  # where nobody says how many
    assert scored == [name for name, rung in read_rungs().items() if not rung.card.scores]


def test_a_curve_is_timed_without_its_evaluations(monkeypatch):
    now = SimpleNamespace(seconds=1000.0)
    monkeypatch.setattr(play, "time", SimpleNamespace(perf_counter=lambda: now.seconds))
    asked = []

    def slow(keywords, act, seeds):
        asked.append(list(seeds))
        now.seconds += 50.0
        return [1.0] * len(seeds)

    monkeypatch.setattr(play, "play", slow)
    watch = Watch(TINY, 800, 2)
    for step in (1, 2):
        assert [watch.due(100 * step - 1), watch.due(100 * step)] == [False, True]
        now.seconds += 10.004
        watch.evaluate(100 * step, None, lambda step=step: step)
    assert [point["wall_s"] for point in watch.curve] == [10.0, 20.01]
    assert [point["robot_steps"] for point in watch.curve] == [100, 200]
    assert asked == [list(HELD_BACK_SEEDS[:2])] * 2
    assert watch.best == 1, "the second one is no better"
    assert POINTS == 8


def test_a_decision_of_four_robots_lasts_their_ticks():
    assert robot_steps_of_a_decision({**TINY, "decision_period": 5}) == 20.0
    assert robot_steps_of_a_decision({**TINY, "decision_period": 1, "discrete": True}) == 4.0


@pytest.mark.parametrize("words", ["cards --workers=0", "ladder --workers=0", "ladder --budget=0",
                                   "ladder --seeds=-1", ""])  # fmt: skip
def test_numbers_of_commands_have_bounds(call, words):
    result, _ = call(*words.split())
    assert result.exit_code == 2
    assert "Usage" in result.output


def test_a_rung_without_scores_is_told_of_before_anything_trains(call, monkeypatch):
    name, known = next(iter(read_rungs().items()))
    bare = replace(known, card=known.card.model_copy(update={"scores": {}}))
    monkeypatch.setattr("training.ladder.rungs.read_rungs", lambda: {name: bare})
    result, done = call("ladder", "--seeds=1")
    assert isinstance(result.exception, ConfigError)
    assert done.jobs == []
    assert call("ladder", "--seeds=0")[0].exit_code == 0
