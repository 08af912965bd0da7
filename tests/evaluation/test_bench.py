"""The bench measures what it says, on small worlds."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pymunk
import pytest

from baselines.cli import run
from baselines.evaluation.bench import speed
from baselines.evaluation.bench.cases import (
    Case,
    all_cases,
    enlarged,
    uniform_poses,
)
from baselines.evaluation.bench.speed import (
    SHARES,
    bare_pymunk,
    case_speeds,
    seconds_per_tick,
    stage_shares,
    thread_gain,
)
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture
def case():
    return replace(all_cases()[0], warm_up=20)


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_the_stages_make_up_the_tick(case, physics):
    shares = stage_shares(case, physics, quick=True)
    assert tuple(shares) == SHARES
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-3)
    for stage in ("decide", "engine", "tick", "observe"):
        assert shares[stage] > 0.0, "each stage is still where the clock is put"


class Clock:
    """A clock that goes on only where it is told to."""

    def __init__(self, monkeypatch):
        self.now = 0.0
        monkeypatch.setattr(speed, "time", SimpleNamespace(perf_counter=lambda: self.now))

    def tick(self, *lengths):
        """A tick of so many seconds; of several lengths, one after the other, the last for good."""
        left = list(lengths)

        def run():
            self.now += left.pop(0) if len(left) > 1 else left[0]

        return run


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


@dataclass(frozen=True)
class Clocked(Case):
    """A case whose ticks take what a function of engine and threads says, on a clock."""

    tick_of: Callable[..., Any] = None

    def tick(self, physics, quick, threads=1):
        return self.tick_of(physics, quick, threads)


@pytest.fixture
def clocked(case):
    """Make a case of two worlds of es1 whose ticks a function makes."""
    return lambda tick_of: Clocked(case.name, case.scenario, 2, tick_of=tick_of)


@pytest.mark.parametrize("quick", [True, False])
def test_the_time_of_a_tick_is_its_time(clock, quick):
    assert seconds_per_tick(clock.tick(0.001), quick) == pytest.approx(0.001)
    repeats, length = (3, 0.15) if quick else (5, 0.5)
    assert clock.now == pytest.approx(0.001 * (1 + 3) + repeats * length)


def test_a_hiccup_does_not_count(clock):
    first = [0.01] * (1 + 3)  # one tick to start, three to see how many fill the time
    hiccup = [0.01] * 7 + [50.0] + [0.01] * 7
    assert seconds_per_tick(clock.tick(*first, *hiccup, 0.01), quick=True) == pytest.approx(0.01)


def test_speeds_are_robot_steps_a_second(clock, clocked, monkeypatch):
    asked, lengths = [], {"rigid": 0.004, "kinematic": 0.001}

    def tick_of(physics, quick, threads):
        asked.append((physics, quick, threads))
        return clock.tick(lengths[physics])

    monkeypatch.setattr(speed, "bare_pymunk", lambda case: clock.tick(0.002))
    speeds = case_speeds(clocked(tick_of), quick=True)
    assert asked == [("rigid", True, 1), ("kinematic", True, 1)]
    assert speeds["rows"] == 20
    assert speeds["rigid"] == pytest.approx(20 / 0.004)
    assert speeds["kinematic"] == pytest.approx(20 / 0.001)
    assert speeds["bare_pymunk"] == pytest.approx(20 / 0.002)
    assert speeds["rigid_over_bare"] == pytest.approx(2.0)


def test_what_threads_gain_is_the_time_on_one_over_that_on_several(clock, clocked):
    lengths = {("kinematic", 1): 0.004, ("kinematic", 2): 0.0025, ("rigid", 1): 1.0}
    timed = clocked(lambda physics, quick, threads: clock.tick(lengths[physics, threads]))
    assert thread_gain(timed, "kinematic", 2, quick=True) == pytest.approx(1.6)


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_what_is_timed_is_a_tick_of_a_swarm_under_way(case, physics):
    loop = case.start(physics, quick=False)
    before = loop.world.robots["pose"].copy()
    loop.step()
    moved = np.hypot(*(loop.world.robots["pose"] - before)[0, :, :2].T)
    assert (moved > 0.0).mean() > 0.5


@pytest.mark.parametrize("n_worlds", [1, 3])
def test_bare_pymunk_steps_every_world_of_a_case(case, n_worlds, monkeypatch):
    stepped, inner = [], pymunk.Space.step

    def step(space, dt):
        before = np.array([tuple(body.position) for body in space.bodies])
        inner(space, dt)
        after = np.array([tuple(body.position) for body in space.bodies])
        stepped.append((id(space), dt, (before != after).any(axis=1).sum()))

    monkeypatch.setattr(pymunk.Space, "step", step)
    bare_pymunk(replace(case, n_worlds=n_worlds))()
    assert len({space for space, _, _ in stepped}) == n_worlds
    assert sum(dt for _, dt, _ in stepped) == pytest.approx(n_worlds * case.scenario.tick)
    assert {moving for _, _, moving in stepped} == {case.scenario.task.n_robots}


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
