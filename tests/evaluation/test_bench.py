"""The bench measures what it says, on small worlds."""

import ctypes
import json
import re
from dataclasses import replace
from importlib.util import find_spec
from types import SimpleNamespace
from unittest.mock import MagicMock, call

import numpy as np
import pymunk
import pytest

from baselines.evaluation.bench import gpu, measures, speed
from baselines.evaluation.bench.cases import all_cases, enlarged, uniform_poses
from baselines.evaluation.bench.gpu import card_bandwidth, energy_meter, vmas_seconds
from baselines.evaluation.bench.measures import memory_growth, seconds
from baselines.evaluation.bench.speed import (
    SHARES,
    bare_pymunk,
    case_speeds,
    seconds_per_tick,
    stage_shares,
    thread_gain,
)
from baselines.evaluation.bench.tables import check, goals_of, gpu_table
from swarm_forage_env.scenarios import find_scenario
from tests.evaluation.conftest import printed


@pytest.fixture
def case():
    return replace(all_cases()[0], warm_up=20)


def test_the_stages_make_up_the_tick(case):
    shares = stage_shares(case, "rigid", quick=True)
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


@pytest.mark.parametrize("quick", [True, False])
def test_the_time_of_a_tick_is_its_time(clock, quick):
    assert seconds_per_tick(clock.tick(0.001), quick) == pytest.approx(0.001)
    repeats, length = (3, 0.15) if quick else (5, 0.5)
    assert clock.now == pytest.approx(0.001 * (1 + 3) + repeats * length)


def test_a_hiccup_does_not_count(clock):
    first = [0.01] * (1 + 3)  # one tick to start, three to see how many fill the time
    hiccup = [0.01] * 7 + [50.0] + [0.01] * 7
    assert seconds_per_tick(clock.tick(*first, *hiccup, 0.01), quick=True) == pytest.approx(0.01)


def test_speeds_are_robot_steps_a_second_and_threads_gain_time(clock, monkeypatch):
    lengths = {("rigid", 1): 0.004, ("kinematic", 1): 0.001, ("rigid", 2): 0.0025}

    def tick(physics, quick, threads=1):
        return clock.tick(lengths[physics, threads])

    case = SimpleNamespace(name="two", rows=20, n_ticks=1, tick=tick)
    monkeypatch.setattr(speed, "bare_pymunk", lambda case: clock.tick(0.002))
    assert case_speeds(case, quick=True) == pytest.approx({
        "case": "two", "rows": 20, "rigid": 20 / 0.004, "kinematic": 20 / 0.001,
        "bare_pymunk": 20 / 0.002, "rigid_over_bare": 2.0,
    })  # fmt: skip
    assert thread_gain(case, "rigid", 2, quick=True) == pytest.approx(1.6)


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


@pytest.fixture
def found():
    """What the bench may have found."""
    speeds = {"rigid": 1e6, "kinematic": 1e6, "bare_pymunk": 2e6, "rigid_over_bare": 2.0}
    found = {
        "quick": True,
        "machine": {"python": "3.11", "cores": 2},
        "speeds": [{"case": case.name, "rows": case.rows, **speeds} for case in all_cases()],
        "stages": [{"case": "es1 x 30", "physics": "kinematic",
                    "shares": dict.fromkeys(SHARES, 1.0 / len(SHARES))}],
        "threads": [{"physics": physics, "threads": 2, "gain": gain}
                    for physics, gain in (("kinematic", 1.8), ("rigid", 1.2))],
        "start_up_s": {"import": 0.2, "help": 0.5, "list": 3.0},
        "memory": {"ticks": 1000, "peak_mb": 200.0, "growth_mb": 0.0},
        "peak_memory_mb": 300.0,
    }  # fmt: skip
    return found | {"budgets": check(found)}


def test_budgets_are_met_from_their_right_side(found):
    met = {each["what"] for each in found["budgets"] if each["is_met"]}
    missed = {each["what"] for each in found["budgets"]} - met
    assert {"es3, rigid", "es1, dicts, rigid", "2 threads : 1, kinematic",
            "import swarm_forage_env", "memory growth, 1,000 ticks"} <= met  # fmt: skip
    assert {"es3, kinematic", "2 threads : 1, rigid", "swarm-forage list"} <= missed


def test_the_command_tells_what_was_found(found, monkeypatch, command):
    monkeypatch.setattr(measures, "measure", lambda *_: found)
    status, stdout, stderr = command("bench", "--quick", "--format=json")
    assert (status, json.loads(stdout), stderr) == (0, found, "")
    _, stdout, _ = command("bench", "--quick")
    assert "missed by 67%" in stdout
    assert max(map(len, stdout.splitlines())) <= 80


def test_start_up_is_that_of_new_processes():
    assert 0.0 < seconds("pass", repeats=1) < seconds("import time; time.sleep(1)", repeats=1)


LEAK = """
import json, sys
from baselines.evaluation.bench.measures import peak_memory
before = peak_memory()
kept = b"x" * int(sys.argv[1]) * 2**20
print(json.dumps([before, peak_memory()]))
"""


def test_memory_that_grows_is_seen(monkeypatch):
    monkeypatch.setattr(measures, "LONG_RUN", LEAK)
    peak, growth = memory_growth(100)
    assert growth == pytest.approx(100.0, abs=10.0)
    assert peak > growth


def test_memory_does_not_grow_with_the_ticks():
    peak, growth = memory_growth(20_000)
    assert peak > 10.0
    assert 0.0 <= growth < 0.01 * peak


FOUND = {
    "case": "es1 x 10", "rows": 100, "gpu": 1.2e9, "environment": 1.25e8, "cpu": 3e6, "threads": 16,
    "shares": {"decide": 0.25, "tick": 0.5, "observe": 0.25}, "bytes_per_robot_step": 5120.0,
    "bandwidth": 2.4e12, "share_of_card": 0.5, "joules_per_million": 2.0, "first_step_s": 30.0,
    "made_s": 1.5, "vmas": 2.35e6,
}  # fmt: skip


class Nvml:
    """A driver's library, of which the counter rises by 1.5 J at each reading."""

    def __init__(self, status=0):
        self.status, self.used, self.asked = status, 0, b""

    def nvmlInit_v2(self):  # noqa: N802 NVML's name
        return 0

    def nvmlDeviceGetHandleByUUID(self, uuid, gpu):  # noqa: N802 NVML's name
        self.asked = uuid
        return 0

    def nvmlDeviceGetTotalEnergyConsumption(self, gpu, used):  # noqa: N802 NVML's name
        self.used += 1500
        ctypes.cast(used, ctypes.POINTER(ctypes.c_ulonglong))[0] = self.used
        return self.status


def test_the_table_tells_what_was_measured_and_a_dash_for_what_the_driver_does_not_tell():
    names = "bandwidth", "share_of_card", "joules_per_million", "vmas"
    unknown = {"shares": {}, **dict.fromkeys(names)}
    table = gpu_table([FOUND, FOUND | unknown])
    assert "…" not in printed(table, 80)
    rows = [line.partition("es1 x 10")[2].split() for line in printed(table, 140).splitlines()]
    known, open_ = filter(None, rows)
    assert known == [
        "1,200", "125", "2.35", "3", "16", "25%", "50%", "25%", "5120", "2400", "50%", "2", "30.0",
    ]  # fmt: skip
    assert open_.count("-") == 7


def test_a_row_stands_beside_its_goal():
    fast, large = FOUND | {"case": "es1 x 1000"}, FOUND | {"case": "es1 x 100000"}
    assert not goals_of([FOUND])
    goals = {each["what"]: each for each in goals_of([fast, large])}
    assert {what: (each["budget"], each["is_met"]) for what, each in goals.items()} == {
        "es1 x 1000: GPU": (250.0, True),
        "es1 x 1000: learning": (150.0, False),
        "es1 x 100000: made and reset": (2.0, True),
    }
    shown = printed(gpu_table([fast, large]))
    assert re.search(r"es1 x 1000: learning +125 M/s +150 M/s +missed by 17%", shown)


def test_vmas_is_timed_where_it_is_installed(monkeypatch):
    assert find_spec("vmas") or vmas_seconds(2, quick=True) is None
    vmas = MagicMock()
    env = vmas.make_env.return_value
    env.agents, env.get_random_action = "ab", lambda agent: agent
    env.step.return_value = None, [np.zeros(2)] * 2, None, None
    monkeypatch.setattr(gpu, "find_spec", lambda name: name)
    monkeypatch.setattr(gpu, "import_module", lambda name: vmas)
    monkeypatch.setattr(gpu, "seconds_per_tick", lambda step, quick: step() or 0.5)
    assert vmas_seconds(3, quick=True, device="cpu") == 0.5
    terms = vmas.make_env.call_args.kwargs
    assert (terms["num_envs"], terms["device"]) == (3, "cpu")
    assert env.method_calls == [call.reset(), call.step(["a", "b"])]


def test_energy_is_told_in_joules_of_the_gpu_that_was_asked_for():
    nvml = Nvml()
    joules = energy_meter("GPU-1", nvml)
    assert nvml.asked == b"GPU-1"
    assert joules() - joules() == pytest.approx(-1.5)
    assert energy_meter("GPU-1", Nvml(status=3)) is None, "a driver that does not tell it"


def test_the_bandwidth_of_a_card_is_that_of_its_memory():
    """An H200: 3.201 GHz, 6144 bits; 4.9 TB/s."""
    card = SimpleNamespace(MEMORY_CLOCK_RATE=3_201_000, GLOBAL_MEMORY_BUS_WIDTH=6144)
    assert card_bandwidth(card) == pytest.approx(4.917e12, rel=1e-3)
    assert card_bandwidth(SimpleNamespace()) is None
