"""The bench of a GPU, without one: its table, its energy, and the card's bandwidth."""

import ctypes
from types import SimpleNamespace

import pytest

from baselines.evaluation.bench.gpu import card_bandwidth, energy_meter, gpu_table
from tests.evaluation.conftest import printed

FOUND = {
    "case": "es1 x 10", "rows": 100, "gpu": 1.2e9, "environment": 1.25e8, "cpu": 3e6, "threads": 16,
    "shares": {"decide": 0.25, "tick": 0.5, "observe": 0.25}, "bytes_per_robot_step": 5120.0,
    "bandwidth": 2.4e12, "share_of_card": 0.5, "joules_per_million": 2.0, "first_step_s": 30.0,
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
    unknown = {"shares": {}, "bandwidth": None, "share_of_card": None, "joules_per_million": None}
    table = gpu_table([FOUND, FOUND | unknown])
    assert "…" not in printed(table, 80)
    rows = [line.partition("es1 x 10")[2].split() for line in printed(table, 140).splitlines()]
    known, open_ = filter(None, rows)
    assert known == [
        "1,200", "125", "3", "16", "25%", "50%", "25%", "5120", "2400", "50%", "2", "30.0",
    ]  # fmt: skip
    assert open_.count("-") == 6


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
