"""The pairs, the claims and the tables on boids that forage."""

import numpy as np
import pytest

from baselines.estimators.sikf import (
    N_MOMENTS,
    add_noise,
    error_constant,
    propagate,
    worst_deviation,
)
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.papers.boids_foraging import (
    ACROSS_ESTIMATORS,
    ACROSS_MOTIONS,
    DEVIATION,
    ESTIMATORS,
    MOTIONS,
    PAPER,
    PATH,
    localisation_error,
    pair,
    table,
)
from baselines.papers.experiments import round_trips
from swarm_forage_env.scenarios import find_scenario


def layers(experiment):
    return experiment.configuration(None).controller.layers


def test_each_claim_is_asked_for_over_all_layers_of_the_other_kind():
    estimators, motions = ACROSS_MOTIONS, ACROSS_ESTIMATORS
    assert estimators[0].pairs == tuple(
        (pair("es1", each, "SGIKF"), pair("es1", each, "dead reckoning")) for each in MOTIONS
    )
    assert motions[-1].pairs == tuple(
        (pair("es2", "boids-goal", each), pair("es2", "boids-adaptive", each))
        for each in ESTIMATORS
    )
    assert (estimators[0].metric, motions[-1].metric) == (round_trips, localisation_error)
    assert PAPER.claims == (*estimators, *motions)
    assert (len(estimators), len(motions)) == (2 * 4, 2 * 5)
    assert len(PAPER.experiments) == 2 * 20


@pytest.mark.parametrize(
    ("motion", "estimator", "name"),
    [
        ("subsumption", "SGIKF", "ssgikf"),
        ("learned-motion", "SGIFF", "learned-motion:beta=0.001"),
        ("boids-static", "dead reckoning", "boids-static:estimator=dead_reckoning"),
    ],
)
def test_a_pair_has_the_layers_of_the_controller_of_that_name(motion, estimator, name):
    assert layers(pair("es1", motion, estimator)) == find_layered_controller(name).layers


def test_boids_trust_deviations_as_far_as_the_paths_that_bring_them():
    scenario = find_scenario("es1")
    step = scenario.robot.cruise_speed * scenario.tick
    k = error_constant(scenario.sensors.wheel_noise, scenario.robot.cruise_speed, scenario.tick)
    P = np.zeros(N_MOMENTS)  # noqa: N806 as in the paper
    for _ in range(round(PATH / step)):
        propagate(P, step, 0.0)
        add_noise(P, step, 0.0, k * step, k * step, scenario.robot.axle)
    assert worst_deviation(P) == pytest.approx(DEVIATION, rel=0.05)
    for estimator, trust in {"SGIFF": PATH, "covariance intersection": DEVIATION}.items():
        assert layers(pair("es1", "boids-adaptive", estimator))["motion"].trust == trust


def test_the_tables_mark_what_is_better_and_worse_than_ssgikf(episodes):
    seeds = range(8)
    results = {
        each: episodes(each, [100 + k for k in seeds], localisation_error_m=0.1)
        for each in PAPER.experiments
    }
    high, low, nobody = (pair("es1", "boids-goal", each) for each in list(ESTIMATORS)[1:])
    results[high] = episodes(high, [200 + k for k in seeds], localisation_error_m=0.2)
    results[low] = episodes(low, [50 + k for k in seeds], localisation_error_m=0.05)
    results[nobody] = episodes(nobody, [100 + k for k in seeds], localisation_error_m=None)
    lines = table(results).splitlines()
    (row, errors) = (line for line in lines if line.startswith("| es1 | boids-goal |"))
    cells = [cell.strip() for cell in row.split("|")[3:-1]]
    assert [cell.partition(" ")[0] for cell in cells] == ["104", "**204", "54", "104"]
    assert [cell[-1] for cell in cells] == [")", "*", "†", ")"]
    assert errors.endswith("| 10.0 (10.0 to 10.0) | 20.0 (20.0 to 20.0) † "
                           "| **5.0 (5.0 to 5.0)** | - |")  # fmt: skip
    (ratios,) = (line for line in lines if line.startswith("| es1: subsumption above boids-goal |"))
    assert [cell.strip()[-1] for cell in ratios.split("|")[2:-1]] == [")", "†", "*", ")"]
    assert "**1.93 (" in ratios
