"""The search for open numbers: its prior, distances, weights and stages, and what is told."""

import math
from dataclasses import asdict, replace

import numpy as np
import pyarrow as pa
import pytest

from baselines.papers import open_claims, open_search
from baselines.papers.experiments import Experiment
from baselines.papers.open_claims import ARENAS, CHECKED, Sets, experiments_on, held, key_of
from baselines.papers.open_numbers import pairs_table
from baselines.papers.open_prior import PRIOR, configuration, place_of, today, values_of
from baselines.papers.open_search import (
    BATCH,
    FIRST,
    OTHERS,
    Measured,
    distance,
    fit_emulator,
    probabilities,
    probability_within,
)


def episodes(arena, n=4, n_robots=10, **trips):
    """Episodes with as many round trips, which meet all else that is published of es1."""
    recruited, shares = {"nc": 1200.0, "ssgikf": 300.0}, {"nc": 0.1}
    return [
        Measured(arena, name, n_robots, each, shares.get(name, 0.6), recruited.get(name), 1800.0)
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


def test_an_emulator_says_how_probable_it_is_that_a_noisy_number_lies_between_its_ends():
    rng = np.random.default_rng(0)
    draws = rng.random((2000, 3))
    means = np.column_stack([draws[:, 0] ** 2 + draws[:, 1], draws[:, 0] * draws[:, 2]])
    outputs = means + rng.normal(0.0, (0.1, 0.2), means.shape)
    fitted = fit_emulator(draws, outputs, np.ones(len(draws)))
    assert fitted[1] == pytest.approx([0.1, 0.2], rel=0.1)
    low, high = np.array([0.4, 0.0]), np.array([0.6, 0.3])
    inside = ((low < outputs) & (outputs < high)).all(axis=1)
    assert probability_within(draws, fitted, low, high).sum() == pytest.approx(
        inside.sum(), rel=0.1
    )
    far = probability_within(np.array([[0.9, 0.9, 0.5]]), fitted, low, high)
    assert far < 1e-3


def test_the_chance_of_a_set_is_that_of_the_tolerances_by_which_its_distance_is_told():
    draws = np.random.default_rng(0).random((400, len(PRIOR)))
    sets = [
        episodes("es1", nc=60, ssgikf=round(100.0 * 2.0 ** draw[0])) for draw in draws
    ]  # 150 at 0.585
    found = probabilities(draws, draws, sets, "es1")
    near = np.array([distance(each, "es1") for each in sets])
    assert found[near < 0.8].min() > 0.5 > found[near > 1.2].max()
    assert (probabilities(draws, draws, sets, "es2") == 1.0).all(), "nothing was measured there"


def test_a_search_goes_on_where_it_was_and_takes_only_near_sets_further(monkeypatch, tmp_path):
    asked = []

    def measure(sets, experiments, seeds):
        (arena,), controllers = (
            {each.scenario for each in experiments},
            tuple(each.controller for each in experiments),
        )
        asked.append((arena, controllers, len(sets)))
        speeds = [each["robot.cruise_speed"] for each in sets]
        found = {"es1": [round(100 + 1250 * each) for each in speeds], "es2": [1400] * len(sets)}
        return [
            episodes(
                arena, len(seeds), **{c: {"nc": 50, "ssgikf": own}.get(c, 170) for c in controllers}
            )
            for own in found[arena]
        ]

    monkeypatch.setattr(open_search, "measure", measure)
    monkeypatch.setattr(open_search, "CANDIDATES", 2_000)
    for n in (FIRST, FIRST + BATCH, FIRST + 2 * BATCH):
        open_search.search(tmp_path / "parts.parquet", n, seed=3)
    open_search.search(tmp_path / "whole.parquet", FIRST + 2 * BATCH, seed=3)
    parts, whole = (open_search.load(tmp_path / f"{each}.parquet") for each in ("parts", "whole"))
    assert parts.equals(whole)
    going = [n for arena, controllers, n in asked if arena == "es1" and controllers == OTHERS]
    assert 0 < sum(going) < len(parts)
    speeds = np.array(parts["robot.cruise_speed"].to_pylist())
    assert speeds[FIRST:].std() < 0.8 * speeds[:FIRST].std(), "later sets are nearer"


def test_a_claim_holds_where_its_means_lie_and_the_nearest_beta_speaks_for_the_others():
    trips = dict.fromkeys(OTHERS, 140) | {"nc": 60, "ssgikf": 150, "ssgiff:beta=0.01": 170}
    found = held([*episodes("es1", **trips), *episodes("es2", ssgikf=1400)])
    assert [text for text, holds in found.items() if not holds] == [
        "es1: recruitment time of each strategy over the mean of the four",
        "es1: times faster recruitment with communication",
    ]
    worse = held(episodes("es1", **trips | {"ssgiff:beta=0.0001": 160}))
    assert not worse["es1: every other beta below SGIKF"]


def test_the_front_the_best_and_the_pairs_that_exclude_each_other():
    names = "es1: SSGIKF above DSGIKF", "es1: best beta", "es2: best beta"
    rows = [(0, 1, 1), (1, 0, 1), (1, 0, 0), (0, 1, 0)] * 3
    judged = [dict(zip(names, map(bool, row), strict=True)) for row in rows]
    drawn = np.zeros((4, 2)), np.zeros((9, 2)), np.ones((2, 9))
    scores = {"es1": np.array([5, 6, 5, -1]), "es2": np.array([7, 6, 6, 9])}
    sets = Sets(*drawn, {}, {"es2": np.arange(4.0)}, {}, judged, scores)
    assert sets.front("es1", "es2") == [0, 1]
    assert [row.split(" | ")[:2] for row in pairs_table(sets).splitlines()[2:]] == [
        [f"| {names[1]}", names[0]]
    ]
    far = {"es2": np.array([0.0, 9.0, 5.0, 1.0, 2.0])}
    scores = {"es1": np.array([1, 2, -1, 0, 3]), "es2": np.array([1, 2, 9, 0, 1])}
    assert replace(sets, far=far, scores=scores).best("es1", "es2") == [4, 1, 0, 3]
    assert replace(sets, far=far, scores=scores).best("es2") == [2, 1, 0, 4, 3]
    assert replace(sets, far=far, scores=scores).front("es1", "es2") == [4, 1]


def test_the_best_sets_are_measured_in_the_other_arenas_once(monkeypatch, tmp_path):
    """A set gets the areas of es3 that give 2000 trips; today's keeps its own."""
    asked = []

    def measure(sets, experiments, seeds):
        asked.append(({each.scenario for each in experiments}, len(sets)))
        return [
            [
                Measured(of.scenario, of.controller, n_robots, trips, 0.5, 900.0, 3600.0)
                for of in experiments
                for _, _, n_robots in [key_of(of)]
                for trips in [round(1000.0 * values["es3.area_distance"])]
                for _ in seeds
            ]
            for values in sets
        ]

    def whole(values):
        return [
            asdict(Measured(*key, 100, 0.5, 900.0, 1800.0))
            for arena in ARENAS
            for key in dict.fromkeys(map(key_of, experiments_on(arena).values()))
        ]

    draws = [place_of(today()), *np.random.default_rng(0).random((2, len(PRIOR))).tolist()]
    rows = [{"draw": each, **values_of(each)} for each in draws]
    rows = [row | {"episodes": whole(row)} for row in rows]
    monkeypatch.setattr(open_claims, "measure", measure)
    monkeypatch.setattr(open_claims, "N_PRIOR", 10)
    file = tmp_path / "sets.parquet"
    open_search.save(file, pa.Table.from_pylist(rows))
    open_claims.measure_in_all_arenas(file, 1)
    open_claims.measure_in_all_arenas(file, 2)
    sets = open_claims.sets_in(file)
    assert sorted(sets.best(*CHECKED)) == [0, 1, 2]
    assert [n for arenas, n in asked if arenas == {"ants2008"}] == [2, 1]
    distances = [values_of(each)["es3.area_distance"] for each in sets.draws]
    assert distances == [today()["es3.area_distance"], 1.8, 1.8]
