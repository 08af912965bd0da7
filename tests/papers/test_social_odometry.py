"""The claims and figures of TR, Section 6, one by one."""

import pytest

from baselines.papers.beta_sweep import BETAS, BestBeta, OptimumInsideRange, OtherBetasBelow
from baselines.papers.claim_types import Below, Number, Order, Ratio, Share
from baselines.papers.experiments import (
    CrossValidatedBest,
    Pool,
    not_all_recruited,
    on_path,
    recruitment_time,
    round_trips,
)
from baselines.papers.figures import Boxes, Curves, recruitment_time_if_finished
from baselines.papers.social_odometry import social_odometry

TALKING = "ssgikf, dsgikf, best ssgiff, best dsgiff"


@pytest.fixture(scope="module")
def claims():
    return social_odometry().claims


def named(source):
    """A source of samples in words, without its scenario."""
    if isinstance(source, Pool):
        return ", ".join(map(named, source.sources))
    if isinstance(source, CrossValidatedBest):
        names = [each.controller.partition(":") for each in source.experiments]
        assert [float(number.removeprefix("beta=")) for _, _, number in names] == list(BETAS)
        return f"best {names[0][0]}"
    return source.controller


def of_kind(claims, kind, told):
    """What a kind of claims says, by the words of each."""
    found = {each.text: told(each) for each in claims if isinstance(each, kind)}
    for each in claims:
        scenarios = {experiment.scenario for experiment in each.experiments}
        assert scenarios == {each.text.partition(":")[0]}
    return found


def test_the_numbers_of_round_trips_are_of_these_strategies(claims):
    found = of_kind(claims, Number, lambda each: (named(each.source), each.published))
    assert found == {
        "es1: round trips, NC": ("nc", 60.0),
        "es1: round trips, SGIKF": ("ssgikf", 150.0),
        "es1: round trips, SGIFF with the best beta": ("best ssgiff", 170.0),
        "es2: round trips, SGIKF": ("ssgikf", 1400.0),
        "es3: round trips, SGIKF": ("ssgikf", 2000.0),
        "real: round trips, SGIKF": ("ssgikf", 120.0),
        "real: round trips, SGIFF": ("ssgiff:beta=0.01", 140.0),
    }
    assert {each.metric for each in claims if isinstance(each, Number)} == {round_trips}


def test_in_the_larger_arenas_silent_robots_make_fewer_than_fifty_trips(claims):
    assert of_kind(claims, Below, lambda each: (named(each.source), each.bound)) == {
        "es2: round trips, NC": ("nc", 50.0),
        "es3: round trips, NC": ("nc", 50.0),
    }


def test_the_ratios_are_four_of_recruitment_and_two_of_round_trips(claims):
    def told(each):
        return named(each.numerator), named(each.denominator), each.published, each.metric

    assert of_kind(claims, Ratio, told) == {
        "es1: times faster recruitment with communication": ("nc", TALKING, 4.0, recruitment_time),
        "es2: times faster recruitment with communication": ("nc", TALKING, 4.0, recruitment_time),
        "real: round trips, times those of NC": (
            "ssgikf, dsgikf, ssgiff:beta=0.01, dsgiff:beta=0.01", "nc", 2.0, round_trips,
        ),
    }  # fmt: skip


def test_the_shares_are_of_robots_on_the_path_and_of_runs_that_fail(claims):
    def told(each):
        return ", ".join(map(named, each.sources)), each.published, each.metric

    found = of_kind(claims, Share, told)
    for setup in ("es1", "es2", "es3"):
        assert found.pop(f"{setup}: share on the path, with communication") == (
            TALKING, (0.5, 0.7), on_path,
        )  # fmt: skip
        alone = found.pop(f"{setup}: share on the path, NC")
        assert alone == ("nc", (0.0, 0.2), on_path)
    assert found == {
        "real: share on the path, with communication": (
            "ssgikf, dsgikf, ssgiff:beta=0.01, dsgiff:beta=0.01", (0.5, 0.5), on_path,
        ),
        "es3: share of NC runs in which not all robots find the path within 7200 s": (
            "nc", (1.0, 1.0), not_all_recruited,
        ),
    }  # fmt: skip


def test_the_orders_and_the_sweeps_are_of_every_simulated_arena(claims):
    orders = of_kind(claims, Order, lambda each: [tuple(map(named, pair)) for pair in each.pairs])
    assert orders == {
        f"{setup}: {text}": [pair]
        for setup in ("es1", "es2", "es3")
        for text, pair in (
            ("best SGIFF above SGIKF", ("best ssgiff", "ssgikf")),
            ("SSGIKF above DSGIKF", ("ssgikf", "dsgikf")),
            ("SSGIFF above DSGIFF", ("best ssgiff", "best dsgiff")),
        )
    }
    inside = of_kind(claims, OptimumInsideRange, lambda each: each.sweep.filter)
    below = of_kind(claims, OtherBetasBelow, lambda each: named(each.reference))
    setups = ("es1", "es2", "es3")
    best = of_kind(claims, BestBeta, lambda each: (each.sweep.filter, each.published))
    assert best == {
        f"{each}: best beta": ("ssgiff", beta)
        for each, beta in (("es1", 1e-2), ("es2", 1e-2), ("es3", 1e-3))
    }
    assert inside == {f"{each}: best beta inside the swept range": "ssgiff" for each in setups}
    assert below == {f"{each}: every other beta below SGIKF": "ssgikf" for each in setups}
    assert len(claims) == 7 + 2 + 3 + 8 + 9 + 3 + 3 + 3


def test_each_figure_has_its_panels_its_series_and_its_axes():
    figures = {each.name: each for each in social_odometry().figures}
    arenas = ["(a) es1", "(b) es2", "(c) es3"]
    five = ["NC", "SSGIKF", "DSGIKF", "SSGIFF", "DSGIFF"]
    time, trips, path = (
        ("", "time [s]"),
        ("", "round trips"),
        ("time [s]", "robots on the path [%]"),
    )
    for name, titles, series, axes, kind in (
        ("tr13", arenas, five, time, Boxes),
        ("tr14", arenas, five[:3], trips, Boxes),
        ("tr15", arenas, [f"{beta:g}" for beta in BETAS], ("beta [1/cm]", "round trips"), Boxes),
        ("tr16", arenas, five, path, Curves),
        ("tr17", ["real"], five, time, Boxes),
        ("tr18", ["real"], five, trips, Boxes),
        ("tr19", ["real"], five, path, Curves),
    ):
        figure = figures[name]
        assert list(figure.panels) == titles
        assert all(list(panel) == series for panel in figure.panels.values())
        assert figure.axes == axes
        assert type(figure) is kind
        assert figure.caption.startswith(f"TR Fig. {name[2:]}. ")
    for title, panel in figures["tr15"].panels.items():
        for beta, both in panel.items():
            found = {name: (each.scenario, each.controller) for name, each in both.items()}
            where = title.removeprefix("(a) ").removeprefix("(b) ").removeprefix("(c) ")
            assert found == {
                "SSGIFF": (where, f"ssgiff:beta={beta}"), "DSGIFF": (where, f"dsgiff:beta={beta}")
            }  # fmt: skip
    finished = {name for name, each in figures.items()
                if getattr(each, "metric", None) is recruitment_time_if_finished}  # fmt: skip
    assert finished == {"tr13", "tr17"}
