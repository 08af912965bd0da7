"""Made-up episodes for every experiment of a paper."""

import numpy as np
import pytest

from baselines.evaluation import statistics
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.waypoints.episode import WaypointEpisode


@pytest.fixture(autouse=True)
def _few_resamples(monkeypatch):
    """Intervals of 200 resamples for 9,999: what a claim says of one does not depend on it."""
    monkeypatch.setattr(statistics, "RESAMPLES", 200)


def make(experiment, seed, trips=100, **numbers):
    """One episode of an experiment."""
    values = {
        "physics": "kinematic",
        "n_robots": 4,
        "duration_s": 1000.0,
        "round_trips": int(trips),
        "recruitment_time_s": 400.0,
        "on_path_share": 0.6,
        "lost_events": 1,
        "messages": 1,
        "localisation_error_m": 0.1,
        "wall_s": 1.0,
        "on_path_over_time": (0.0, 0.25, 0.5, 0.75),
        "recruited_at_s": (100.0, 200.0, 300.0, 400.0),
    }
    return ForagingEpisode(experiment.scenario, experiment.controller, seed, **values | numbers)


def episodes(experiment, trips, **numbers):
    """Episodes with these round trips; a list of another number gives each its own."""
    each = [
        {name: value[seed] if isinstance(value, list) else value for name, value in numbers.items()}
        for seed in range(len(trips))
    ]
    return [make(experiment, seed, count, **each[seed]) for seed, count in enumerate(trips)]


@pytest.fixture(name="episodes")
def _episodes():
    return episodes


@pytest.fixture
def made_up():
    """Results for all experiments of a paper, of many seeds, at random."""

    def make_up(paper, n_seeds=8):
        rng = np.random.default_rng(0)
        return {
            experiment: waypoints(experiment, rng, n_seeds)
            if experiment.scenario.startswith("waypoints")
            else episodes(experiment, rng.integers(50, 200, n_seeds).tolist())
            for experiment in paper.experiments
        }

    return make_up


def waypoints(experiment, rng, n_seeds):
    """Episodes of robots that visit waypoints, whose numbers are drawn."""
    about = experiment.scenario, experiment.controller
    return [
        WaypointEpisode(*about, seed, "kinematic", 10, 100.0, *rng.random(6), wall_s=0.0)
        for seed in range(n_seeds)
    ]
