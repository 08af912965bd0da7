"""The search for static gains of the boids."""

import json
from dataclasses import replace

import pytest

from baselines.evaluation.dataset import Dataset
from swarm_forage_env.waypoints.episode import WaypointEpisode

pytest.importorskip("optuna")
from calibration import boids_gains

EPISODE = WaypointEpisode(
    "waypoints-10-authors", "boids-goal", 0, "kinematic", 10, 100.0,
    covariance_norm=0.05, position_error_m=0.1, largest_error_m=0.5,
    goals_per_robot=2.0, false_goals_per_robot=1.0, success_rate=2 / 3, wall_s=0.0,
)  # fmt: skip


def test_a_swarm_that_does_better_costs_less():
    better = replace(EPISODE, covariance_norm=0.04)
    assert boids_gains.cost(better) < boids_gains.cost(EPISODE)
    better = replace(EPISODE, goals_per_robot=3.0)
    assert boids_gains.cost(better) < boids_gains.cost(EPISODE)
    better = replace(EPISODE, success_rate=1.0)
    assert boids_gains.cost(better) < boids_gains.cost(EPISODE)
    none = replace(EPISODE, success_rate=None)
    assert boids_gains.cost(none) > boids_gains.cost(EPISODE)


def test_a_search_for_gains_is_kept_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(boids_gains, "ESTIMATORS", {"dead_reckoning": ""})
    monkeypatch.setattr(boids_gains, "SIZES", (5,))
    monkeypatch.setattr(boids_gains, "FIT_TRIALS", 2)
    asked = []

    def price(dataset, backend, each, seeds):
        asked.append(each.controller.motion)
        return [each.controller.motion.homing for _ in seeds]

    monkeypatch.setattr(boids_gains, "costs", price)
    dataset = Dataset(tmp_path / "episodes")
    dataset.open()
    (first,) = boids_gains.search_gains(dataset, 3, 0, 1, lambda _: None)
    assert len(asked) == 3
    assert asked[0].homing == 1.0, "gains of one are tried first"
    assert first.cost == min(motion.homing for motion in asked)
    (second,) = boids_gains.search_gains(dataset, 5, 0, 1, lambda _: None)
    assert len(asked) == 5
    assert second.cost <= first.cost
    file = boids_gains.write_gains(tmp_path, [second])
    assert json.loads(file.read_text())[0]["gains"] == pytest.approx(second.gains)
