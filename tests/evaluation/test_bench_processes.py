"""What the bench measures in processes of their own: start-up and memory."""

import pytest

from baselines.evaluation.bench import measures
from baselines.evaluation.bench.measures import memory_growth, seconds


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
    peak, growth = memory_growth(200)
    assert peak > 10.0
    assert 0.0 <= growth < 5.0
