"""The bench measures what it says, on small worlds."""

import json
from dataclasses import replace

import numpy as np
import pytest

from baselines.cli import run
from baselines.evaluation.bench.bare import bare_pymunk
from baselines.evaluation.bench.cases import (
    BatchCase,
    DictionaryCase,
    all_cases,
    enlarged,
    uniform_poses,
)
from baselines.evaluation.bench.processes import memory_growth, seconds
from baselines.evaluation.bench.speed import case_speeds, seconds_per_tick, thread_gain
from baselines.evaluation.bench.stages import STAGES, stage_shares
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture
def case():
    return replace(all_cases()[0], warm_up=20)


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_the_stages_make_up_the_tick(case, physics):
    shares = stage_shares(case, physics, quick=True)
    assert tuple(shares) == STAGES
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-3)
    for stage in ("decide", "engine", "tick", "observe"):
        assert shares[stage] > 0.0, "each stage is still where the clock is put"


def test_the_time_of_a_tick_is_its_time():
    import time

    assert seconds_per_tick(lambda: time.sleep(0.01), quick=True) == pytest.approx(0.01, rel=0.5)


def test_speeds_are_positive(case):
    speeds = case_speeds(case, quick=True)
    assert min(speeds[name] for name in ("rigid", "kinematic", "bare_pymunk")) > 0.0
    assert speeds["rows"] == 10


@pytest.mark.parametrize("kind", [BatchCase, DictionaryCase])
def test_the_environment_is_driven_past_the_end_of_an_episode(kind):
    short = find_scenario("es1", {"task.duration": 1.0})
    step = kind("short", short, n_worlds=1, warm_up=20).tick("kinematic", quick=False)
    for _ in range(20):
        step()


def test_what_threads_gain_is_a_ratio_of_speeds(case):
    assert thread_gain(replace(case, n_worlds=2), "kinematic", 2, quick=True) > 0.0


def test_bare_pymunk_steps_every_case(case):
    bare_pymunk(case)()
    bare_pymunk(replace(case, n_worlds=3))()


@pytest.mark.parametrize("factor", [1, 10, 100])
def test_an_enlarged_scenario_has_the_same_density(factor):
    es3 = find_scenario("es3")
    larger = enlarged(es3, factor)
    assert larger.task.n_robots == factor * es3.task.n_robots
    density = [s.task.n_robots / (s.arena.length * s.arena.width) for s in (es3, larger)]
    assert density[0] == pytest.approx(density[1])


@pytest.mark.parametrize("name", ["es1", "es3"])
def test_spread_robots_stand_inside_and_apart(name):
    scenario = find_scenario(name)
    for pose in uniform_poses(scenario, 3):
        x, y = pose[:, 0], pose[:, 1]
        radius = scenario.robot.radius
        assert (np.abs(x) <= 0.5 * scenario.arena.length - radius).all()
        assert (np.abs(y) <= 0.5 * scenario.arena.width - radius).all()
        apart = np.hypot(x[:, None] - x, y[:, None] - y) + np.eye(len(x))
        assert apart.min() >= 2.0 * radius


def test_budgets_are_met_from_their_right_side(measures):
    verdict = {each["what"]: each["is_met"] for each in measures["budgets"]}
    assert verdict["es3, rigid"]
    assert not verdict["es3, kinematic"]
    assert verdict["es1, dicts, rigid"]
    assert verdict["2 threads : 1, kinematic"]
    assert not verdict["2 threads : 1, rigid"]
    assert verdict["import swarm_forage_env"]
    assert not verdict["swarm-forage list"]
    assert verdict["memory growth, 1,000 ticks"]


@pytest.mark.parametrize("form", ["table", "json"])
def test_the_command_tells_what_was_found(measures, monkeypatch, capsys, form):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("baselines.evaluation.bench.measures.measure", lambda *_: measures)
    assert run(["bench", "--quick", f"--format={form}"]) == 0
    stdout, stderr = capsys.readouterr()
    assert stderr == ""
    if form == "json":
        assert json.loads(stdout) == measures
    else:
        assert "missed by 67%" in stdout
        assert max(map(len, stdout.splitlines())) <= 80


def test_start_up_and_memory_are_those_of_new_processes():
    assert 0.0 < seconds("pass", repeats=1) < seconds("import time; time.sleep(1)", repeats=1)
    peak, growth = memory_growth(20)
    assert peak > 10.0
    assert growth >= 0.0
