"""Threads: each runs its own worlds, and how many there are changes nothing."""

import os
import signal

import pytest

from swarm_forage_env import thread_team
from swarm_forage_env.errors import ConfigError

ENGINES = ("rigid", "kinematic")
BUSY = {"cruise_speed": 0.12, "area_distance": 0.7, "wheel_noise": 0.02}
"""Fast robots and near areas: round trips and exchanges within a minute."""
SEEDS = range(7)
TICKS = 400


@pytest.mark.parametrize("physics", ENGINES)
def test_the_same_bits_on_any_number_of_threads(running, bits, physics):
    found = []
    for threads in (1, 2, 3, 7, 20):
        loop = running("es1", SEEDS, physics, "dsgikf", threads, duration=60.0, **BUSY)
        loop.run(TICKS)
        found.append(bits(loop))
    assert all(each == found[0] for each in found)
    assert loop.world.robots["messages"].sum() > 0
    assert loop.world.robots["round_trips"].sum() > 0


@pytest.mark.parametrize("n_polls", [0, 1, 10, None])
def test_two_blocks_that_take_turns_run_as_alone(running, bits, monkeypatch, n_polls):
    """Whether a thread still polls, sleeps, or has not yet seen its run when the caller sleeps."""
    if n_polls is not None:
        monkeypatch.setattr(thread_team, "polls_for", lambda seconds: n_polls)
    alone, *blocks = (running("es1", SEEDS, "kinematic", threads=each) for each in (1, 2, 2))
    for loops in ([alone], [alone], blocks[:1], blocks[1:], blocks):
        for k in range(150):
            for loop in loops:
                loop.run(1 + k % 3)
                if k % 20 == 0:
                    loop._on_all_threads(lambda first, last: None)
    assert bits(alone) == bits(blocks[0]) == bits(blocks[1])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork")
def test_a_forked_process_runs_on_with_threads_of_its_own(running, bits):
    loop, same = (running("es1", SEEDS, "kinematic", threads=2) for _ in range(2))
    for each in (loop, same):
        each.run(50)
    same.run(50)
    child = os.fork()  # right after a run, while the other thread still polls
    if child == 0:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(30)
        loop.run(50)
        os._exit(bits(loop) != bits(same))
    assert os.waitpid(child, 0)[1] == 0


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True, None])
def test_a_number_of_threads_that_is_none_is_refused(running, threads):
    with pytest.raises(ConfigError, match="threads="):
        running("es1", [0], threads=threads)
