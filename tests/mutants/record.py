"""A plugin of pytest: which test ran which line, and for how long; see docs/reliability.md.

Under `coverage run` each test is a context of its own, with its fixtures. Only tests that pass
count. As plain Python some are skipped, and here so is what takes long.
"""

import json
import os
import signal
import time

import coverage
import pytest

LONGEST = 10.0
"""Seconds of a processor after which a test is skipped; long runs of whole worlds are."""

SECONDS = {}
PASSED = set()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Name the test whose lines are recorded, and take its time of a processor."""
    coverage.Coverage.current().switch_context(item.nodeid)
    began = time.process_time()
    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    result = yield
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    SECONDS[item.nodeid] = time.process_time() - began
    coverage.Coverage.current().switch_context("")
    return result


def stop(number, frame):
    """End a test that takes too long."""
    pytest.skip(f"takes more than {LONGEST:g} s as plain Python")


def pytest_runtest_logreport(report):
    """Note which tests pass."""
    if report.when == "call" and report.passed:
        PASSED.add(report.nodeid)


def pytest_sessionfinish():
    """Write the seconds of the tests that passed."""
    passed = {test: seconds for test, seconds in SECONDS.items() if test in PASSED}
    with open(os.environ["MUTANTS_SECONDS"], "w", encoding="utf-8") as out:
        json.dump(passed, out)
