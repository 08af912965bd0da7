"""What the bench measures in processes of their own: start-up and memory."""

import json

import pytest

from baselines.evaluation.bench import measures
from baselines.evaluation.bench.measures import memory_growth, seconds


def test_start_up_is_that_of_new_processes():
    assert 0.0 < seconds("pass", repeats=1) < seconds("import time; time.sleep(1)", repeats=1)


def test_the_import_is_timed_without_python_itself(monkeypatch):
    lengths = {"pass": 0.1, "import swarm_forage_env": 0.35}
    asked = []

    def seconds_of(code, *arguments, repeats):
        asked.append((code, *arguments))
        return lengths.get(code, 1.0)

    monkeypatch.setattr(measures, "seconds", seconds_of)
    found = measures.start_up(quick=True)
    assert found["import"] == pytest.approx(0.25)
    assert found["import_with_environment"] == pytest.approx(0.9)
    assert (found["help"], found["list"]) == (1.0, 1.0)
    assert {each[1] for each in asked if len(each) > 1} == {"--help", "list"}


def test_the_first_run_finds_no_machine_code(monkeypatch):
    found = "import json, os; print(json.dumps(os.listdir(os.environ['XDG_CACHE_HOME'])))"
    listed = []
    inner = measures._run
    monkeypatch.setattr(measures, "FIRST_RUN", found)
    monkeypatch.setattr(measures, "_run", lambda *a, **k: listed.append(inner(*a, **k)))
    assert measures.first_run() > 0.0
    assert [json.loads(each) for each in listed] == [[]]


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
