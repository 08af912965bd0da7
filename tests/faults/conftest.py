"""How often each fault is tried, what is told of it, and how a run that was stopped goes on."""

import hashlib
import json
import os
import random
import resource
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

TRIES = int(os.environ.get("FAULTS", "100"))
"""Scales how often every fault is tried: 100 for as often as docs/reliability.md tells."""

SEED = int(os.environ.get("FAULTS_SEED", "1"))

KEPT = Path(os.environ.get("FAULTS_OUT", ROOT / "runs" / "faults"))
"""Folder in which a run keeps what it has tried, so that the same command goes on from there."""


def code():
    """A hash of all code and of these tests: what was tried of other code does not count."""
    text = hashlib.sha256()
    for folder in ("swarm_forage_env", "baselines", "training", "tests/faults"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            text.update(file.read_bytes())
    return text.hexdigest()[:12]


RESULTS = KEPT / f"{TRIES}-seed{SEED}-{code()}.jsonl"
"""A line for each test that has passed: its name, what was tried, and what came of it."""


def passed():
    """What each test that has passed told."""
    lines = RESULTS.read_text("utf-8").splitlines() if RESULTS.exists() else []
    return {row["test"]: row["told"] for row in map(json.loads, lines)}


PASSED_BEFORE = passed()


@pytest.fixture(autouse=True)
def _goes_on(request):
    """What has passed in a run that was stopped is not tried again."""
    if request.node.name in PASSED_BEFORE:
        pytest.skip(f"passed before: {RESULTS}")


@pytest.fixture
def tries():
    """A function: how often a fault is tried, of which there are so many where FAULTS is 100."""

    def number(of_a_hundred):
        return max(1, round(TRIES * of_a_hundred / 100))

    return number


@pytest.fixture
def rng(request):
    """Random numbers of this test, from the seed that is printed."""
    return random.Random(f"{SEED} {request.node.name}")


def processor_seconds():
    """Processor time of this process and of the children that it has waited for [s]."""
    who = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
    used = [resource.getrusage(each) for each in who]
    return sum(each.ru_utime + each.ru_stime for each in used)


@pytest.fixture
def tell(request, capsys):
    """Print and keep how often a fault was tried, and what came of it: the last act of a test."""
    before = processor_seconds()

    def told(**counts):
        counts["processor_s"] = round(processor_seconds() - before, 1)
        numbers = ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in counts.items())
        with capsys.disabled():
            sys.stdout.write(f"\n{request.node.name}, seed {SEED}: {numbers}\n")
        KEPT.mkdir(parents=True, exist_ok=True)
        with RESULTS.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"test": request.node.name, "told": counts}) + "\n")

    return told


def pytest_terminal_summary(terminalreporter):
    """All that was tried, as a table."""
    found = passed()
    if found:
        terminalreporter.section(f"faults, FAULTS={TRIES}, seed {SEED}")
        for test, counts in found.items():
            numbers = ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in counts.items())
            terminalreporter.write_line(f"| {test.removeprefix('test_')} | {numbers} |")
        took = sum(counts.get("processor_s", 0.0) for counts in found.values())
        terminalreporter.write_line(f"processor time of all: {took:.0f} s")
