"""How long a plan will take, from a short run of each scenario."""

from types import SimpleNamespace

import pytest

from baselines.evaluation.runner import MAX_ROWS
from baselines.papers import reproduction
from baselines.papers.experiments import Experiment
from baselines.papers.reproduction import (
    expected_seconds,
    format_duration,
    run_for,
    seconds_per_tick,
)


@pytest.fixture
def clock(monkeypatch):
    """A clock that a test moves; what it starts at must not matter."""
    now = SimpleNamespace(seconds=1000.0)
    monkeypatch.setattr(reproduction, "time", SimpleNamespace(perf_counter=lambda: now.seconds))
    return now


def test_a_loop_runs_in_beats_of_twenty_ticks_until_the_time_is_up(clock):
    def run(n_ticks):
        clock.seconds += 0.01 * n_ticks

    loop = SimpleNamespace(run=run)
    assert run_for(loop, 0.5) == (60, pytest.approx(0.6))  # after 40 ticks 0.4 s are spent
    assert run_for(loop, 0.0) == (0, 0.0)


def test_a_tick_of_a_world_is_timed_after_the_robots_had_time_to_meet(monkeypatch, clock):
    """Blocks of a usual size; the second 0.3 s, whose beats are slower here, are what counts."""
    made, spent = [], []

    class Loop:
        def __init__(self, scenario, controller, seeds, physics):
            made.append((scenario, controller, len(seeds), physics))

        def run(self, n_ticks):
            for _ in range(n_ticks):
                so_far = sum(spent)  # exact in binary
                spent.append(1 / 1024 if so_far < 0.3125 else 2 / 1024 if so_far < 0.625 else 0.125)
                clock.seconds += spent[-1]

    monkeypatch.setattr(reproduction, "Loop", Loop)
    monkeypatch.setattr(reproduction, "warm_up", lambda configuration: None)
    for n_robots, n_worlds in ((10, MAX_ROWS // 10), (MAX_ROWS, 1), (MAX_ROWS + 1, 1)):
        spent.clear()
        scenario = SimpleNamespace(task=SimpleNamespace(n_robots=n_robots))
        found = SimpleNamespace(scenario=scenario, controller="nc", physics="kinematic")
        assert seconds_per_tick(found) == pytest.approx(2 / 1024 / n_worlds)
        assert made.pop() == (scenario, "nc", n_worlds, "kinematic")
    assert made == []


def plan(*configurations, todo):
    return SimpleNamespace(
        configurations=configurations,
        todo={each.key: range(n) for each, n in zip(configurations, todo, strict=True) if n},
    )


def test_each_scenario_is_timed_once_and_only_if_something_is_left_to_run(monkeypatch):
    few, same, many, other = (
        Experiment(scenario, controller, (f"task.n_robots={n}", f"task.duration={seconds}"))
        .configuration("kinematic")
        for scenario, controller, n, seconds in (
            ("es1", "nc", 5, 100), ("es1", "ssgikf", 5, 100), ("es1", "nc", 10, 100),
            ("es2", "nc", 5, 200),
        )
    )  # fmt: skip
    timed = []

    def speed(configuration):
        timed.append(configuration)
        return 0.25 * len(timed)

    monkeypatch.setattr(reproduction, "seconds_per_tick", speed)
    assert expected_seconds(plan(few, same, many, other, todo=(0, 2, 3, 1)), 2) == pytest.approx(
        (0.25 * 2 * 1000 + 0.5 * 3 * 1000 + 0.75 * 1 * 2000) / 2
    )
    assert timed == [same, many, other]
    timed.clear()
    assert expected_seconds(plan(few, same, todo=(1, 3)), 1) == pytest.approx(0.25 * 4 * 1000)
    assert timed == [few]
    assert expected_seconds(plan(few, same, todo=(0, 0)), 1) == 0.0


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(59.4, "59 s"), (60.0, "1 min"), (149.0, "2 min"), (3599.0, "60 min"), (3600.0, "1.0 h"),
     (5400.0, "1.5 h"), (0.0, "0 s")],
)  # fmt: skip
def test_durations_change_their_unit_at_a_minute_and_at_an_hour(seconds, words):
    assert format_duration(seconds) == words
