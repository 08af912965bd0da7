"""The bench of a GPU, without one: its table, its energy, and the card's bandwidth."""

import ctypes
import re
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest

from baselines.evaluation.bench import gpu
from baselines.evaluation.bench.gpu import card_bandwidth, energy_meter, vmas_seconds
from baselines.evaluation.bench.gpu_tables import goals_of, gpu_table
from tests.evaluation.conftest import printed

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


def row_of(found):
    """The row of a table in which nothing is cut short."""
    text = printed(gpu_table([found]), 140)
    assert "…" not in printed(gpu_table([found]), 80)
    return next(line for line in text.splitlines() if "es1 x 10" in line)


def test_the_table_tells_what_was_measured():
    row = row_of(FOUND)
    assert row.removeprefix("es1 x 10").split() == [
        "1,200", "125", "2.35", "3", "16", "25%", "50%", "25%", "5120", "2400", "50%", "2", "30.0",
    ]  # fmt: skip


def test_what_the_driver_does_not_tell_is_a_dash():
    names = "bandwidth", "share_of_card", "joules_per_million", "vmas"
    unknown = {"shares": {}, **dict.fromkeys(names)}
    assert row_of(FOUND | unknown).split().count("-") == 7


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
    asked = []

    class Navigation:
        agents = "ab"

        def reset(self):
            asked.append("reset")

        def get_random_action(self, agent):
            return agent

        def step(self, actions):
            asked.append(actions)
            return None, [np.zeros(2)] * 2, None, None

    made = SimpleNamespace(make_env=lambda **terms: asked.append(terms) or Navigation())
    monkeypatch.setattr(gpu, "find_spec", lambda name: name)
    monkeypatch.setattr(gpu, "import_module", lambda name: made)
    monkeypatch.setattr(gpu, "seconds_per_tick", lambda step, quick: step() or 0.5)
    assert vmas_seconds(3, quick=True, device="cpu") == 0.5
    assert (asked[0]["num_envs"], asked[0]["device"]) == (3, "cpu")
    assert asked[1:] == ["reset", ["a", "b"]]


def test_energy_is_told_in_joules_of_the_gpu_that_was_asked_for():
    nvml = Nvml()
    joules = energy_meter("GPU-1", nvml)
    assert nvml.asked == b"GPU-1"
    assert joules() - joules() == pytest.approx(-1.5)


def test_a_driver_that_does_not_tell_energy_has_no_meter():
    assert energy_meter("GPU-1", Nvml(status=3)) is None


def test_the_bandwidth_of_a_card_is_that_of_its_memory():
    """An H200: 3.201 GHz, 6144 bits; 4.9 TB/s."""
    card = SimpleNamespace(MEMORY_CLOCK_RATE=3_201_000, GLOBAL_MEMORY_BUS_WIDTH=6144)
    assert card_bandwidth(card) == pytest.approx(4.917e12, rel=1e-3)
    assert card_bandwidth(SimpleNamespace()) is None
