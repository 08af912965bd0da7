"""The claims and figures of ANTS, Section 5, one by one."""

import pytest

from baselines.papers.ants2008 import LOCAL, SIZES, ants2008, experiment_of_size, slopes
from baselines.papers.beta_sweep import BETAS, BestBeta
from baselines.papers.claim_types import Contrast, NoDifference, Order
from baselines.papers.experiments import Experiment, recruitment_time, round_trips
from baselines.papers.figures import Boxes

MOST = "ssgiff:beta=0.001"
"""Local communication: the single Fermi filter with the published beta."""


def at(controller, *sizes):
    """The experiments of a controller with groups of these sizes."""
    return [Experiment("ants2008", controller, (f"task.n_robots={size}",)) for size in sizes]


@pytest.fixture(scope="module")
def paper():
    return ants2008()


def test_each_order_is_of_the_experiments_that_it_names(paper):
    orders = {
        each.text.removeprefix("ants2008: "): (each.metric, list(each.pairs))
        for each in paper.claims
        if isinstance(each, Order)
    }
    pairs = {
        "no odometry error above local, at every group size": zip(
            at("no-error", *SIZES), at(MOST, *SIZES), strict=True
        ),
        "local above no communication, at every group size": zip(
            at(MOST, *SIZES), at("nc", *SIZES), strict=True
        ),
        "local above global": [(Experiment("ants2008", MOST), Experiment("ants2008", "global"))],
    }
    faster = "recruitment of 30 and more robots faster with communication"
    late = list(zip(at("nc", 30, 40, 50), at(MOST, 30, 40, 50), strict=True))
    expected = {text: (round_trips, list(each)) for text, each in pairs.items()}
    assert orders == expected | {faster: (recruitment_time, late)}


def test_what_does_not_differ_is_covariance_knowledge_and_the_smallest_group(paper):
    found = {
        each.text: (each.one, each.other, each.metric)
        for each in paper.claims
        if isinstance(each, NoDifference)
    }
    assert found == {
        "ants2008: local and covariance knowledge do not differ significantly": (
            Experiment("ants2008", MOST), Experiment("ants2008", "covariance"), round_trips,
        ),
        "ants2008: recruitment of 2 robots does not differ with communication": (
            *at("nc", 2), *at(MOST, 2), recruitment_time,
        ),
    }  # fmt: skip


def test_the_best_beta_is_one_in_a_thousand_and_the_gain_bends_at_ten_robots(paper):
    (best,) = (each for each in paper.claims if isinstance(each, BestBeta))
    assert (best.published, best.sweep.scenario, best.sweep.filter) == (1e-3, "ants2008", "ssgiff")
    (bend,) = (each for each in paper.claims if isinstance(each, Contrast))
    assert bend.text == "ants2008: local gains more a robot below 10 robots than above"
    assert list(bend.experiments) == at(MOST, *SIZES)
    assert len(paper.claims) == 8


def test_the_group_at_the_bend_belongs_to_both_slopes(episodes):
    """Least squares by hand: 10 robots bring in 10, all other groups nothing."""
    results = {
        experiment_of_size(LOCAL, size): episodes(
            experiment_of_size(LOCAL, size), [10 * (size == 10), 20 * (size == 10)]
        )
        for size in SIZES
    }
    below, above = slopes(results)
    first = 10 * (10 - 17 / 3) / (98 / 3)  # sizes 2, 5, 10: mean 17/3, squares about it 98/3
    assert below == pytest.approx([first, 2 * first])
    second = 10 * (10 - 27.5) / 1187.5  # sizes 10 to 50: mean 27.5, squares about it 1187.5
    assert above == pytest.approx([second, 2 * second])


def test_each_figure_has_its_axes_its_panels_and_its_metric(paper):
    found = {
        each.name: (each.axes, {title: list(panel) for title, panel in each.panels.items()},
                    each.metric if isinstance(each, Boxes) else None)
        for each in paper.figures
    }  # fmt: skip
    sizes = [str(size) for size in (2, 5, 10, 15, 20, 30, 40, 50)]
    assert found == {
        "ants2a": (("beta [1/cm]", "round trips"),
                   {"ants2008": [f"{beta:g}" for beta in BETAS]}, round_trips),
        "ants2b": (("", "round trips"),
                   {"ants2008": ["no communication", "no odometry error", "covariance knowledge",
                                 "global communication", "local communication"]}, round_trips),
        "ants3a": (("robots", "time [s]"), {"ants2008": sizes}, recruitment_time),
        "ants3a_each": (("k", "time [s]"),
                        {"ants2008": ["no communication", "local communication"]}, None),
        "ants3b": (("robots", "round trips"), {"ants2008": sizes}, round_trips),
    }  # fmt: skip
    series = {each.name: list(next(iter(each.panels["ants2008"].values())))
              for each in paper.figures if isinstance(each, Boxes)}  # fmt: skip
    assert series == {
        "ants2a": [""], "ants2b": [""], "ants3a": ["no communication", "local communication"],
        "ants3b": ["no odometry error", "local communication", "no communication"],
    }  # fmt: skip
