"""Which robots each claim of TR, Section 6, is of, and what each of its figures shows."""

import pytest

from baselines.papers.beta_sweep import BETAS, BestBeta, OptimumInsideRange, OtherBetasBelow
from baselines.papers.claim_types import Order
from baselines.papers.experiments import (
    CrossValidatedBest,
    Pool,
    not_all_recruited,
    on_path,
    recruitment_time,
    round_trips,
)
from baselines.papers.figures import Boxes, Curves, recruitment_time_if_finished
from baselines.papers.social_odometry import PAPER

TALKING = "ssgikf, dsgikf, best ssgiff, best dsgiff"
OF_REAL = "ssgikf, dsgikf, ssgiff:beta=0.01, dsgiff:beta=0.01"
LATE = "share of NC runs in which not all robots find the path within 7200 s"

SOURCES = {
    "round trips, NC": ["nc"],
    "round trips, SGIKF": ["ssgikf"],
    "round trips, SGIFF with the best beta": ["best ssgiff"],
    "each strategy with communication above NC": [*TALKING.split(", "), "nc"],
    "best SGIFF above SGIKF": ["best ssgiff", "ssgikf"],
    "best beta inside the swept range": ["best ssgiff"],
    "best beta": ["best ssgiff"],
    "every other beta below SGIKF": ["best ssgiff", "ssgikf"],
    "SSGIKF above DSGIKF": ["ssgikf", "dsgikf"],
    "SSGIFF above DSGIFF": ["best ssgiff", "best dsgiff"],
    "times faster recruitment with communication": ["nc", TALKING],
    "recruitment time of each strategy over the mean of the four": [*TALKING.split(", "), TALKING],
    LATE: ["nc"],
    "share on the path, with communication": TALKING.split(", "),
    "share on the path, NC": ["nc"],
    "real: round trips, SGIFF": ["ssgiff:beta=0.01"],
    "real: round trips, times those of NC": [OF_REAL, "nc"],
    "real: times faster recruitment with communication": ["nc", OF_REAL],
    "real: share on the path, with communication": [OF_REAL],
}
"""The robots of a claim by its text, with the setup where that matters."""


def named(source):
    """A source of samples in words, without its scenario."""
    if isinstance(source, Pool):
        return ", ".join(map(named, source.sources))
    if isinstance(source, CrossValidatedBest):
        names = [each.controller.partition(":") for each in source.experiments]
        assert [float(number.removeprefix("beta=")) for _, _, number in names] == list(BETAS)
        return f"best {names[0][0]}"
    return source.controller


def sides(pairs):
    """The first sources of pairs and the second one that they share."""
    firsts, seconds = zip(*pairs, strict=True)
    assert set(seconds) == {seconds[0]}
    return [*firsts, seconds[0]]


def sources_of(claim):
    match claim:
        case Order():
            return sides(claim.pairs)
        case OtherBetasBelow():
            return claim.sweep.best, claim.reference
        case BestBeta() | OptimumInsideRange():
            return (claim.sweep.best,)
    return sides(claim.sources) if isinstance(claim.sources[0], tuple) else claim.sources


@pytest.mark.parametrize("claim", PAPER.claims, ids=lambda claim: claim.text)
def test_a_claim_is_of_the_robots_and_the_metric_that_it_names(claim):
    setup, _, text = claim.text.partition(": ")
    assert {experiment.scenario for experiment in claim.experiments} == {setup}
    expected = SOURCES[claim.text if claim.text in SOURCES else text]
    assert [named(source) for source in sources_of(claim)] == expected
    metric = {"times faster": recruitment_time, "recruitment": recruitment_time,
              "share of NC": not_all_recruited, "share on the": on_path,
              }.get(text[:12].strip(), round_trips)  # fmt: skip
    assert getattr(claim, "metric", round_trips) is metric


FIVE = ["NC", "SSGIKF", "DSGIKF", "SSGIFF", "DSGIFF"]
TIME, TRIPS, PATH = ("", "time [s]"), ("", "round trips"), ("time [s]", "robots on the path [%]")


@pytest.mark.parametrize(
    ("name", "setups", "series", "axes", "kind"),
    [
        ("tr13", "abc", FIVE, TIME, Boxes),
        ("tr14", "abc", FIVE[:3], TRIPS, Boxes),
        ("tr15", "abc", [f"{beta:g}" for beta in BETAS], ("beta [1/cm]", "round trips"), Boxes),
        ("tr16", "abc", FIVE, PATH, Curves),
        ("tr17", "real", FIVE, TIME, Boxes),
        ("tr18", "real", FIVE, TRIPS, Boxes),
        ("tr19", "real", FIVE, PATH, Curves),
    ],
)
def test_each_figure_has_its_panels_its_series_and_its_axes(name, setups, series, axes, kind):
    (figure,) = (each for each in PAPER.figures if each.name == name)
    titles = ["(a) es1", "(b) es2", "(c) es3"] if setups == "abc" else [setups]
    assert list(figure.panels) == titles
    assert all(list(panel) == series for panel in figure.panels.values())
    assert (figure.axes, type(figure)) == (axes, kind)
    metric = getattr(figure, "metric", None)
    assert (metric is recruitment_time_if_finished) == (axes == TIME)
