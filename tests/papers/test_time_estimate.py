"""How long a plan will take, from a short run of each scenario."""

from types import SimpleNamespace

import pytest

from baselines.papers import reproduction
from baselines.papers.experiments import Experiment
from baselines.papers.reproduction import expected_seconds, format_duration


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
