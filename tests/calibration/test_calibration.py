"""The score, the ranges, a search that goes on after a kill, and the command on tiny worlds."""

import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from calibration.ranges import (
    ARENAS,
    RANGES,
    controller_with,
    defaults,
    rounded,
    scenario_with,
)
from calibration.source_edits import source_edits
from calibration.targets import (
    CONTROLLERS,
    FARTHEST,
    SGIFF,
    TARGETS,
    Target,
    estimate,
    measure,
    of_arenas,
    score,
    term,
)
from swarm_forage_env.foraging.episode import ForagingEpisode

pytest.importorskip("optuna")
from calibration.runner import sensitivity
from calibration.search import BestTrial, Search

ROOT = Path(__file__).resolve().parents[2]

DEFAULTS = defaults()

EPISODE = ForagingEpisode(
    scenario="es1",
    controller="nc",
    seed=0,
    physics="kinematic",
    n_robots=10,
    duration_s=1800.0,
    round_trips=0,
    recruitment_time_s=None,
    on_path_share=0.1,
    lost_events=0,
    messages=0,
    localisation_error_m=None,
    wall_s=1.0,
)


def cell(*trips, times=None):
    return [
        replace(EPISODE, seed=seed, round_trips=n, recruitment_time_s=times and times[seed])
        for seed, n in enumerate(trips)
    ]


def trips(kind, published, weight=1.0, **more):
    return Target("round_trips", "es1", ("nc",), kind, published, weight, **more)


@pytest.mark.parametrize(
    ("kind", "ours", "expected"),
    [
        ("equal", 60.0, 0.0),
        ("equal", 120.0, math.log(2.0)),
        ("equal", 30.0, math.log(2.0)),
        ("at most", 30.0, 0.0),
        ("at most", 120.0, math.log(2.0)),
        ("at least", 120.0, 0.0),
        ("at least", 30.0, math.log(2.0)),
        ("equal", 0.0, FARTHEST),
        ("at most", 0.0, 0.0),
        ("at least", 1e-9, FARTHEST),
        ("at most", math.inf, FARTHEST),
        ("at least", math.inf, FARTHEST),
    ],
)
def test_a_term_is_the_log_ratio_on_the_wrong_side(kind, ours, expected):
    assert term(trips(kind, 60.0), ours) == pytest.approx(expected)
    assert term(trips(kind, 60.0, weight=0.25), ours) == pytest.approx(0.25 * expected)


def test_the_score_adds_up_weighted_terms():
    measured = {trips("equal", 60.0): 120.0, trips("at most", 50.0, 0.5): 100.0}
    assert score(measured) == pytest.approx(1.5 * math.log(2.0))
    assert score({}) == 0.0


def test_a_target_is_measured_as_the_best_mean_or_as_a_ratio_of_means():
    cells = {
        ("es1", "nc"): cell(50, 70, times=(1600.0, None)),
        ("es1", "ssgikf"): cell(100, 200, times=(300.0, 500.0)),
        ("es1", SGIFF[0]): cell(150, 190),
        ("es1", SGIFF[1]): cell(300, 0),
    }
    best = Target("round_trips", "es1", SGIFF, "equal", 170.0, 1.0)
    assert measure(trips("equal", 60.0), cells) == 60.0
    assert measure(best, cells) == 170.0
    assert measure(replace(best, over="ssgikf"), cells) == pytest.approx(170.0 / 150.0)
    recruitment = Target("recruitment_time_s", "es1", ("nc",), "equal", 4.0, 1.0, "ssgikf")
    assert measure(recruitment, cells) == pytest.approx(1700.0 / 400.0)
    found = estimate(best, cells)
    assert (found.value, found.n) == (170.0, 2)
    assert found.interval[0] <= 170.0 <= found.interval[1]


def test_a_ratio_to_nothing_costs_as_much_as_can_be():
    cells = {("es1", "nc"): cell(0, 0), ("es1", "ssgikf"): cell(0, 0)}
    target = trips("at least", 1.05, over="ssgikf")
    assert term(target, measure(target, cells)) == FARTHEST
    assert estimate(target, cells) is None


def test_every_target_speaks_of_controllers_that_are_run():
    for target in TARGETS:
        assert {*target.controllers, target.over} <= {*CONTROLLERS, ""}
        assert target.arena in ARENAS
        assert target.weight > 0.0
    assert sum(len(of_arenas([arena])) for arena in ARENAS) == len(TARGETS) == len(set(TARGETS))


@pytest.mark.parametrize("each", RANGES, ids=lambda each: each.name)
def test_both_ends_of_every_range_make_scenarios_and_controllers(each):
    assert each.low < each.high
    assert each.reason
    for end in (each.low, each.high):
        values = DEFAULTS | {each.name: end}
        for arena in ARENAS:
            scenario = scenario_with(values, arena, {})
            assert scenario.task.area_distance == values[f"{arena}.area_distance"]
        controller = controller_with(values, "ssgiff:beta=0.5")
        assert controller.parameters["estimator.pause"] == values["estimator.pause"]
        assert controller.parameters["weighting.beta"] == 0.5


@pytest.mark.parametrize("each", RANGES, ids=lambda each: each.name)
def test_a_step_aside_is_within_the_range_and_no_standstill(each):
    for value in (each.low, each.high, rounded(DEFAULTS)[each.name]):
        below, above = each.step_around(value)
        assert each.low <= below <= value <= above <= each.high
        assert below < above


def test_the_defaults_lie_within_the_ranges():
    for each in RANGES:
        assert each.low <= DEFAULTS[each.name] <= each.high


def test_the_lines_to_change_hold_the_values():
    assert list(source_edits(defaults())) == []
    changed = defaults() | {"robot.cruise_speed": 0.0456, "es3.area_distance": 2.345}
    told = [str(edit) for edit in source_edits(changed)]
    assert len(told) == 2
    assert "0.0456" in told[0].partition("\n+")[2]
    assert "area_distance=2.345" in told[1].partition("\n+")[2]
    for edit in source_edits(changed):
        source = (ROOT / edit.file).read_text(encoding="utf-8").splitlines()
        assert source[edit.number - 1] == edit.before


def valley(values, arena):
    """A stub: an arena's trips are right where each value is a tenth below its default."""
    off = sum(abs(values[each.name] - DEFAULTS[each.name] * 0.9) for each in RANGES)
    return {trips("equal", 60.0, source=arena): 60.0 * math.exp(0.01 * off)}


def tried(folder, trials, objective=valley, seed=3):
    search = Search(folder, objective, "stub", seed)
    told = []
    try:
        search.run(trials, None, told.append)
        return told, search.best
    finally:
        search.close()


def test_the_search_begins_with_the_defaults_and_stops_what_is_too_far_off(tmp_path):
    told, best = tried(tmp_path, 30)
    assert len(told) == 30
    assert any("stopped" in line for line in told[3:])
    assert best.score <= score(
        {t: x for arena in ARENAS for t, x in valley(rounded(DEFAULTS), arena).items()}
    )
    assert BestTrial.read(tmp_path / "best.json") == best
    assert tried(tmp_path, 30) == ([], best), "nothing is repeated"


def test_a_search_broken_off_at_any_arena_goes_on_as_if_it_had_not_been(tmp_path):
    unbroken, best = tried(tmp_path / "unbroken", 26)
    calls = iter(range(1000))

    def killed(values, arena):
        if next(calls) % 20 == 11:
            raise KeyboardInterrupt
        return valley(values, arena)

    broken = []
    for _ in range(20):
        search = Search(tmp_path / "broken", killed, "stub", 3)
        try:
            search.run(26, None, broken.append)
            break
        except KeyboardInterrupt:
            continue
        finally:
            search.close()
    scores = [[line.partition(": ")[2] for line in lines] for lines in (unbroken, broken)]
    assert scores[0] == scores[1]
    assert search.best.values == best.values


def test_no_trial_starts_when_time_is_up(tmp_path):
    search = Search(tmp_path, valley, "stub")
    search.run(5, 0.0)
    assert (search.n_ended, search.best) == (0, None)
    search.close()


def test_each_parameter_is_varied_alone():
    def told(values, arena):
        changed = {name for name, value in values.items() if value != DEFAULTS[name]}
        assert len(changed) == 1
        return valley(values, arena)

    varied = list(sensitivity(DEFAULTS, told))
    assert {each.parameter for each in varied} == {each.name for each in RANGES}
    assert len(varied) == 2 * len(RANGES) - 2, "none above: es1; none below: hold"


COMMAND = "social-odometry", "--workers=1", "--set=task.duration=3"


def start(*options, cwd):
    environment = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "120"}
    environment.pop("SWARM_CHECK_SHAPES", None)
    return subprocess.Popen(
        [sys.executable, "-m", "calibration", *COMMAND, *options],
        cwd=cwd,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_two_trials_of_a_tiny_scenario_killed_between(tmp_path):
    first = start("--trials=2", cwd=tmp_path)
    for line in first.stderr:
        if "trial 0" in line:
            break
    first.send_signal(signal.SIGKILL)
    first.communicate(timeout=60)
    second = start("--trials=2", "--report=2", cwd=tmp_path)
    stdout, stderr = second.communicate(timeout=120)
    assert second.returncode == 0, stderr
    assert "1 of 2 trials found" in stderr
    assert "es3    round trips, ssgikf" in stdout
    assert "change these lines" in stdout
    report = json.loads((tmp_path / "runs/calibrate-social-odometry/report.json").read_text())
    assert len(report) == len(TARGETS)
    assert not stdout.startswith("swarm-forage:")


@pytest.mark.parametrize("gone", ["episodes", "."])
def test_a_folder_that_is_deleted_in_mid_run_is_told_in_one_line(tmp_path, gone):
    run = start("--trials=3", cwd=tmp_path)
    for line in run.stderr:
        if "trial 1" in line:
            break
    folder = tmp_path / "runs/calibrate-social-odometry"
    shutil.rmtree(folder / gone)
    stdout, stderr = run.communicate(timeout=120)
    assert run.returncode == 1
    last = stderr.splitlines()[-1]
    if gone == "episodes":
        assert "change these lines" in stdout, "the run goes on to its end"
        assert re.search(r"/episodes: \d+ of \d+ episodes are not there any more: scenario=", last)
    else:
        assert "/trials.sqlite: not there any more (" in last
        assert "Traceback" not in stderr


def test_a_damaged_database_of_trials_is_told_in_one_line(tmp_path):
    folder = tmp_path / "runs/calibrate-social-odometry"
    folder.mkdir(parents=True)
    (folder / "trials.sqlite").write_bytes(b"nothing of use" * 100)
    run = start("--trials=3", cwd=tmp_path)
    stderr = run.communicate(timeout=120)[1]
    assert run.returncode == 1
    (line,) = stderr.splitlines()
    assert "/trials.sqlite: damaged, or on a full disk (file is not a database)" in line


def test_without_a_trial_the_defaults_are_reported_on(tmp_path):
    told = start("--trials=0", "--report=1", "--out=none", cwd=tmp_path)
    stdout, stderr = told.communicate(timeout=120)
    assert told.returncode == 0, stderr
    assert stdout.startswith("The defaults; no trial has ended yet")
    assert "change these lines" not in stdout
    assert len(json.loads((tmp_path / "none/report.json").read_text())) == len(TARGETS)


def test_an_option_that_boids_do_not_have_is_refused_in_one_line(capsys, monkeypatch, tmp_path):
    from baselines.cli import run
    from calibration.command import app

    monkeypatch.chdir(tmp_path)
    assert run(["boids", "--set=a=1", "--sensitivity"], app) == 2
    told = "swarm-forage: --set, --sensitivity: for social-odometry only, not for boids\n"
    assert capsys.readouterr() == ("", told)
    assert run(["boid"], app) == 2
    assert capsys.readouterr().err.endswith("See: python -m calibration --help\n")
