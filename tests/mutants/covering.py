"""Tests that can notice a mutant: those that ran its statement while nothing was mutated.

They come first, and after them all tests of their files, which may share a fixture that ran it. A
statement that runs at import, such as a number of a module or a field of a class, may be read by a
test that runs no line of its module: it is given to every test.

    python -m tests.mutants.covering FOLDER GROUP   # once: run every test, note what it ran

FOLDER/code holds the code without mutants, FOLDER/GROUP.coverage which test ran which line.
"""

import ast
import difflib
import json
import os
import resource
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from coverage import CoverageData

QUIET = ("-q", "-p", "no:cacheprovider", "--assert=plain")
LEFT_OUT = (
    "slow", "faults", "reproduces", "wheel", "site", "browser", "torchrl", "rllib", "ray", "cuda",
    "gpu",
)  # fmt: skip
MOST_SECONDS = 60
"""Seconds of a processor, as recorded, that the chosen tests may take; the fastest come first."""

IMPORT = ""
"""The context of what runs while no test does: at import, or in a module of tests."""

LIMIT = 120
"""Seconds of a processor after which a mutant counts as noticed: it does not end."""


def record(folder, group):
    """Run every test of a group under coverage."""
    config = tomllib.loads(Path(f"tests/mutants/{group}.toml").read_text())["cosmic-ray"]
    paths = [Path(path) for path in config["module-path"]]
    include = ",".join(str(path / "*" if path.is_dir() else path) for path in paths)
    data = (folder / f"{group}.coverage").resolve()
    partial = data.with_suffix(".partial")
    partial.unlink(missing_ok=True)
    markers = " and ".join(f"not {name}" for name in LEFT_OUT)
    environment = os.environ | {"MUTANTS_SECONDS": str(data.with_suffix(".seconds"))}
    subprocess.run(
        [
            *(sys.executable, "-m", "coverage", "run", "--rcfile=/dev/null"),
            *(f"--data-file={partial}", f"--include={include}", "-m", "pytest", *QUIET),
            *("-p", "tests.mutants.record", "-m", markers, *config["covering"]["tests"]),
        ],
        env=environment,
        check=False,  # tests that fail as plain Python notice nothing, and are left out
    )
    partial.rename(data)


def run(folder, group):
    """Run the tests that cover the mutated line, the fastest first; the status is pytest's."""
    module, line = mutated(folder)
    seconds = json.loads((folder / f"{group}.seconds").read_text())
    data = CoverageData(str(folder / f"{group}.coverage"))
    data.read()
    ran = covering(data, module, line)
    files = {file_of(test) for test in ran}
    related = {test for test in seconds if file_of(test) in files or IMPORT in ran}
    chosen = sorted(related, key=lambda test: (test not in ran, seconds[test]))
    affordable, total = [], 0.0
    for test in chosen:
        if total + seconds[test] <= MOST_SECONDS or not affordable:
            total += seconds[test]
            affordable.append(test)
    sys.stdout.write(f"{module}:{line}: {len(affordable)} of {len(chosen)} covering tests\n")
    if not affordable:
        return 0
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
    sys.stdout.flush()
    return int(pytest.main(["-x", *QUIET, *affordable]))


def mutated(folder):
    """The module that differs from the code without mutants, and its first line that does."""
    for before in sorted((folder / "code").rglob("*.py")):
        module = before.relative_to(folder / "code")
        if os.path.getmtime(module) == os.path.getmtime(before):
            continue
        then, now = before.read_text(), module.read_text()
        if then != now:
            matcher = difflib.SequenceMatcher(None, then.splitlines(), now.splitlines())
            first = next(each for each in matcher.get_opcodes() if each[0] != "equal")
            return module, first[1] + 1
    raise SystemExit("no module of this tree is mutated")


def covering(data, module, line):
    """The tests that ran a statement, and IMPORT if it runs without a test."""
    names = [name for name in data.measured_files() if Path(name) == module.resolve()]
    ran = data.contexts_by_lineno(names[0]) if names else {}
    if not in_function(module, line):
        return {IMPORT, *(test for tests in ran.values() for test in tests)}
    return {test for each in statement(module, line) for test in ran.get(each, ())}


def file_of(test):
    """The file of a test."""
    return test.partition("::")[0]


def in_function(module, line):
    """Whether a line runs when a function is called: not the defaults of its parameters."""
    return any(
        isinstance(node, ast.FunctionDef) and node.body[0].lineno <= line <= node.end_lineno
        for node in ast.walk(ast.parse(module.read_text()))
    )


def statement(module, line):
    """The lines of the innermost statement that holds a line; of a compound one, its header."""
    lines = range(line, line + 1)
    for node in ast.walk(ast.parse(module.read_text())):  # outer statements come first
        if isinstance(node, ast.stmt) and node.lineno <= line <= node.end_lineno:
            body = getattr(node, "body", None)
            last = body[0].lineno - 1 if body else node.end_lineno
            lines = range(node.lineno, max(last, node.lineno) + 1)
            if line > last:
                lines = range(line, line + 1)
    return lines


if __name__ == "__main__":
    record(Path(sys.argv[1]), sys.argv[2])
