"""What runs on every push is what a developer runs, under every Python that is promised."""

import re
import tomllib
from itertools import product
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
PYTHONS = {
    name.rpartition(" ")[2]
    for name in PROJECT["classifiers"]
    if re.fullmatch(r"Programming Language :: Python :: 3\.\d+", name)
}
PINNED = r"actions/[a-z-]+@[0-9a-f]{40}"
SYSTEMS = {"ubuntu-latest": "POSIX :: Linux", "macos-latest": "MacOS"}


@pytest.fixture(scope="module")
def jobs():
    """Every job of every workflow, by name."""
    found = {}
    for file in FILES:
        found |= yaml.safe_load(file.read_text(encoding="utf-8"))["jobs"]
    return found


def commands(job):
    return [step["run"] for step in job["steps"] if "run" in step]


def matrix_of(job):
    return job.get("strategy", {}).get("matrix", {})


def test_there_are_workflows_that_run_on_a_push_and_on_a_pull_request():
    assert FILES
    for file in FILES:
        started = yaml.safe_load(file.read_text(encoding="utf-8"))[True]  # YAML reads `on` so
        assert {"push", "pull_request"} <= set(started)


def test_every_command_is_a_target_of_the_makefile_and_none_is_forgotten(jobs):
    every = [line for name, job in jobs.items() if name != "windows" for line in commands(job)]
    for command in every:  # Windows has no make
        program, target, *options = command.split()
        assert program == "make", command
        assert target in TARGETS, command
        assert {each.partition("=")[0] for each in options} <= {"PYTHON", "WORKERS"}, command
    assert {each.split()[1] for each in every} >= {"test", "lint", "docs", "test-wheel", "dist"}


def test_the_tests_run_on_the_systems_and_under_every_python_of_the_classifiers(jobs):
    for job in (jobs["test"], jobs["wheel"]):
        matrix = matrix_of(job)
        assert set(product(matrix["os"], matrix["python"])) == set(product(SYSTEMS, PYTHONS))
        assert job["runs-on"] == "${{ matrix.os }}"
    named = {each for each in PROJECT["classifiers"] if each.startswith("Operating System")}
    assert {f"Operating System :: {each}" for each in SYSTEMS.values()} == named
    oldest = min(PYTHONS, key=lambda each: int(each.partition(".")[2]))
    assert PROJECT["requires-python"] == f">={oldest}"


def test_every_python_is_text_and_every_job_ends_in_time(jobs):
    for job in jobs.values():
        assert 0 < job["timeout-minutes"] <= 120
        pythons = matrix_of(job).get("python", [])
        assert all(isinstance(each, str) for each in pythons), "3.10 is no 3.1"
        for step in job["steps"]:
            assert "run" in step or re.fullmatch(PINNED, step["uses"])
