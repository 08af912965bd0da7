"""What holds for every test: hypothesis repeats itself, no window opens."""

import contextlib
import faulthandler
import os
import resource
import signal
import time

import numba
import numpy as np
import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

LIMITS = {"slow": 3600.0, "faults": 4 * 3600.0, "reproduces": 24 * 3600.0}
"""How long a test of a marker may take [s]; `timeout` of pyproject.toml holds for all others."""

GRACE = 60.0
"""How much later the process of a test ends that its limit did not end [s]."""

STDERR = os.dup(2)
"""Where stacks are printed; pytest captures the other one."""


TOLD = 500
"""After so many tests it is said how long the others will take."""


def pytest_configure():
    """Not captured yet, if this file is one of those that pytest was asked for."""
    os.dup2(2, STDERR)


def pytest_sessionstart(session):
    """Where tests are counted: the process that spreads them over others, or the only one."""
    if not hasattr(session.config, "workerinput"):
        session.config.pluginmanager.register(TimeLeft(session))


class TimeLeft:
    """Says now and then how long the tests that are left will take, at the pace so far."""

    def __init__(self, session):
        self._session, self._begin, self._done = session, time.monotonic(), 0

    def pytest_runtest_logfinish(self):
        self._done += 1
        if self._done % TOLD == 0:
            left = self._session.testscollected - self._done
            seconds = (time.monotonic() - self._begin) / self._done * left
            reporter = self._session.config.pluginmanager.getplugin("terminalreporter")
            reporter.write(f" about {seconds / 60.0:.0f} min left ")


def pytest_collection_modifyitems(items):
    """Tests of some markers have longer limits."""
    for item in items:
        limits = [LIMITS[each.name] for each in item.iter_markers() if each.name in LIMITS]
        if limits:
            item.add_marker(pytest.mark.timeout(max(limits)))


@pytest.hookimpl(wrapper=True)
def pytest_timeout_set_timer(item, settings):
    """A test that waits in C hears no limit: end its process, and xdist starts another."""
    faulthandler.dump_traceback_later(settings.timeout + GRACE, exit=True, file=STDERR)
    return (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_teardown(item):
    """The limit of a test that met it is over, and its end may hang as well."""
    faulthandler.dump_traceback_later(5 * GRACE, exit=True, file=STDERR)


@pytest.hookimpl(wrapper=True)
def pytest_timeout_cancel_timer(item):
    faulthandler.cancel_dump_traceback_later()
    return (yield)


PASSES = 1e-4
"""Least p-value of a test of randomness. Seeds are fixed, so a pass stays a pass."""


@pytest.fixture
def interruptible():
    """Processes that a test starts hear Ctrl-C and SIGHUP, which a job in the background ignores.

    `preexec_fn` would do it too, but can block for ever where the tests have threads.
    """
    before = {signal.SIGINT: signal.signal(signal.SIGINT, signal.default_int_handler)}
    if hasattr(signal, "SIGHUP"):
        before[signal.SIGHUP] = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(autouse=True)
def no_display(monkeypatch):
    """No test opens a window on anybody's screen."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.fixture(autouse=True)
def wrapping_whole_numbers():
    """With the compiler switched off too, 64-bit words are meant to overflow."""
    with np.errstate(over="ignore" if numba.config.DISABLE_JIT else None):
        yield


@pytest.fixture(scope="session")
def fresh():
    """Fresh streams for so many robots, from a fixed seed."""
    from swarm_forage_env.random_streams import NoiseSource, streams

    def make(rows, seed=20090):
        return streams([seed], rows, NoiseSource.ENCODER)

    return make


@pytest.fixture(scope="session")
def believable():
    """Assert that a p-value does not speak against the hypothesis."""

    def check(p_value):
        assert np.all(np.asarray(p_value) > PASSES), p_value

    return check


@pytest.fixture(scope="session")
def busy():
    """An es1 of fast robots and near areas: trips and exchanges soon, whatever is calibrated."""
    from swarm_forage_env.scenarios import find_scenario

    numbers = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.02}
    return find_scenario("es1", numbers)


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Run a command in an empty folder: its exit status, stdout and stderr."""
    from baselines.cli import run
    from swarm_forage_env import compiler

    monkeypatch.setattr(compiler, "announce", lambda: None)  # on stderr, of a cold cache
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def call(*arguments):
        capsys.readouterr()
        status = run([str(argument) for argument in arguments])
        return (status, *capsys.readouterr())

    return call


@pytest.fixture
def full_disk():
    """A context in which no file grows beyond so many bytes: a full disk, for root too."""

    @contextlib.contextmanager
    def limited(n_bytes):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            signal.signal(signal.SIGXFSZ, handler)

    return limited
