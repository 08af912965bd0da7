"""The search for open numbers: its prior, distances, weights and stages, and what is told."""

import math
from dataclasses import replace

import numpy as np
import pytest

from baselines.papers import open_search
from baselines.papers.experiments import Experiment
from baselines.papers.open_claims import Sets, held
from baselines.papers.open_numbers import pairs_table
from baselines.papers.open_prior import PRIOR, configuration, place_of, today, values_of
from baselines.papers.open_search import OTHERS, Measured, distance
from baselines.papers.population import FIRST, GENERATION, Density, densities_of, weights_of


def episodes(arena, n=4, **trips):
    """Episodes with as many round trips, which meet all else that is published of es1."""
    recruited, shares = {"nc": 1200.0, "ssgikf": 300.0}, {"nc": 0.1}
    return [
        Measured(arena, name, each, shares.get(name, 0.6), recruited.get(name), 1800.0)
        for name, each in trips.items()
        for _ in range(n)
    ]


@pytest.mark.parametrize("at", [0.0, 1.0 - 1e-9])
@pytest.mark.parametrize("arena", ["es1", "es2", "es3", "ants2008", "real"])
def test_both_ends_of_the_prior_make_configurations(arena, at):
    values = values_of(np.full(len(PRIOR), at))
    config = configuration(Experiment(arena, "ssgiff:beta=0.01"), values)
    assert config.controller.parameters["estimator.first_hand"] is (at < 0.5)
    assert config.scenario.robot.cruise_speed == values["robot.cruise_speed"]
    home = "es1" if arena == "real" else arena
    assert config.scenario.task.area_distance == values[f"{home}.area_distance"]


def test_todays_set_lies_in_the_prior_at_the_place_that_gives_it_back():
    found = values_of(np.array(place_of(today()), np.float32))
    for name, value in today().items():
        same = value if isinstance(value, str) else pytest.approx(value, rel=1e-2, abs=1e-6)
        assert found[name] == same, name


def test_a_set_is_as_far_as_its_worst_number_in_twice_its_standard_error():
    error = math.sqrt(12.0**2 * (1 / 30 + 1 / 4) + 5.0**2 / 3)
    assert distance(episodes("es1", nc=60, ssgikf=170), "es1") == pytest.approx(20 / (2 * error))
    assert distance(episodes("es1", nc=60, ssgikf=150), "es1") == 0.0
    assert distance(episodes("es1", nc=60, ssgikf=150), "es2") == math.inf
    best = {name: 190 if name == "ssgiff:beta=0.001" else 170 for name in OTHERS}
    ours = episodes("es1", nc=60, ssgikf=150, **best)
    assert distance(ours, "es1") == pytest.approx(20 / (2 * error))


def test_weighted_draws_stand_for_the_prior_whatever_they_were_drawn_around():
    rng = np.random.default_rng(0)
    corner = Density(np.array([[0.1, 0.2], [0.2, 0.1]]), np.array([0.3, 0.7]), np.array([0.1, 0.2]))
    draws = np.concatenate([rng.random((FIRST, 2)), corner.draw(GENERATION, rng)])
    near = (draws < 0.3).all(axis=1)
    weights = weights_of(draws, [corner], len(draws))
    assert near.mean() > 0.15
    assert weights[near].sum() / weights.sum() == pytest.approx(0.09, abs=0.015)
    grid = (np.mgrid[0:200, 0:200].reshape(2, -1).T + 0.5) / 200
    assert corner(grid).mean() == pytest.approx(1.0, abs=1e-3)


def test_a_generation_is_drawn_around_the_nearest_before_it():
    draws = np.random.default_rng(0).random((FIRST + GENERATION, 2))
    (first, second) = densities_of(draws, np.abs(draws - 0.25).max(axis=1))
    assert abs(first.centres - 0.25).max() < 0.35
    assert len(first.centres) == len(second.centres)
    assert (second.widths < 0.3).all()


def test_a_search_goes_on_where_it_was_and_takes_only_near_sets_further(monkeypatch, tmp_path):
    asked = []

    def measure(sets, arena, controllers, seeds):
        asked.append((arena, controllers, len(sets)))
        trips = [
            {"nc": 60, "ssgikf": round(100 + 1250 * each["robot.cruise_speed"])} for each in sets
        ]
        return [episodes(arena, len(seeds), **{c: own.get(c, 170) for c in controllers})
                for own in trips]  # fmt: skip

    monkeypatch.setattr(open_search, "measure", measure)
    for n in (FIRST, FIRST + 65, FIRST + 128):
        open_search.search(tmp_path / "parts.parquet", n, seed=3)
    open_search.search(tmp_path / "whole.parquet", FIRST + 128, seed=3)
    parts, whole = (open_search.load(tmp_path / f"{each}.parquet") for each in ("parts", "whole"))
    assert parts.equals(whole)
    going = [n for arena, controllers, n in asked if arena == "es1" and controllers == OTHERS]
    assert 0 < sum(going) < len(parts)
    speeds = np.array(parts["robot.cruise_speed"].to_pylist())
    assert speeds[FIRST:].std() < 0.8 * speeds[:FIRST].std(), "later sets are nearer"


def test_a_claim_holds_where_its_means_lie_and_the_nearest_beta_speaks_for_the_others():
    trips = dict.fromkeys(OTHERS, 140) | {"nc": 60, "ssgikf": 150, "ssgiff:beta=0.01": 170}
    found = held(episodes("es1", **trips), ["es1"])
    assert [text for text, holds in found.items() if not holds] == [
        "es1: times faster recruitment with communication"
    ]
    worse = held(episodes("es1", **trips | {"ssgiff:beta=0.0001": 160}), ["es1"])
    assert not worse["es1: every other beta below SGIKF"]


def test_the_front_and_the_pairs_are_those_that_no_set_beats_and_that_no_set_holds_together():
    names = "es1: SSGIKF above DSGIKF", "es1: best beta", "es2: best beta"
    rows = [(0, 1, 1), (1, 0, 1), (1, 0, 0), (0, 1, 0)]
    judged = [dict(zip(names, map(bool, row), strict=True)) for row in rows]
    scores = np.array([(5, 7), (6, 6), (5, 6), (-1, 9)])
    sets = Sets(np.zeros((4, 2)), np.ones(4), {}, {}, judged, scores)
    assert sets.front == [0, 1]
    assert [row.split(" | ")[:2] for row in pairs_table(sets).splitlines()[2:]] == [
        [f"| {names[1]}", names[0]]
    ]
    assert replace(sets, scores=np.array([(1, 1), (2, 2), (0, 0), (2, 1)])).front == [1]
