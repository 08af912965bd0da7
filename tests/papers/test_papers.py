"""The papers: their claims are all there, and a run of made-up episodes becomes a page."""

import dataclasses
import importlib
import io
import json
import pkgutil

import pytest
from rich.console import Console

import baselines.papers
from baselines.evaluation import statistics
from baselines.papers import report
from baselines.papers.ants2008 import ants2008
from baselines.papers.figures import write_figures
from baselines.papers.robustness import robustness
from baselines.papers.social_odometry import social_odometry
from baselines.papers.transfer import transfer

PAPERS = {"social-odometry": social_odometry, "ants2008": ants2008, "robustness": robustness,
          "transfer": transfer}  # fmt: skip
FIGURES = {
    "social-odometry": ["tr13", "tr14", "tr15", "tr16", "tr17", "tr18", "tr19"],
    "ants2008": ["ants2a", "ants2b", "ants3a", "ants3a_each", "ants3b"],
    "robustness": ["robustness_messages", "robustness_bodies"],
    "transfer": ["transfer"],
}


@pytest.fixture(params=PAPERS)
def paper(request):
    return PAPERS[request.param]()


def test_every_claim_is_judged_and_named_once(paper, made_up):
    claim_results = paper.judge(made_up(paper))
    names = [each.claim for each in claim_results]
    assert len(set(names)) == len(names) == len(paper.claims)
    for each in json.loads(report.to_json(claim_results)):
        assert set(each) == {"claim", "published", "ours", "low", "high", "reproduced"}


def test_the_report_needs_five_strategies_and_eight_betas_in_three_arenas():
    experiments = social_odometry().experiments
    assert len(experiments) == 3 * (3 + 2 * 8) + 5
    assert [experiment.scenario for experiment in experiments][:19] == ["es3"] * 19, (
        "the longest runs first"
    )


def test_a_claim_its_result_and_what_a_training_is_told_never_change():
    names = [
        f"training.{name}"
        for name in ("candidate_rollouts", "exchanges", "experiment", "learned_weighting",
                     "ladder.rungs", "ladder.runs", "policy_file", "ppo_learner",
                     "tensor_vec_env")
    ]  # fmt: skip
    files = pkgutil.iter_modules(baselines.papers.__path__, "baselines.papers.")
    names += [each.name for each in files]
    kinds = {
        kind
        for module in (statistics, *map(importlib.import_module, names))
        for kind in vars(module).values()
        if dataclasses.is_dataclass(kind) and kind.__module__ == module.__name__
    }
    assert len(kinds) > 35
    assert {kind.__name__ for kind in kinds if not kind.__dataclass_params__.frozen} == set()


def test_every_experiment_can_be_configured(paper):
    change = "kinematic", ["task.duration=10"]
    configurations = [each.configuration(*change) for each in paper.experiments]
    names = {
        (each.key, experiment)
        for each, experiment in zip(configurations, paper.experiments, strict=True)
    }
    assert len(names) == len(paper.experiments)
    assert {each.scenario.task.duration for each in configurations} == {10.0}


def test_every_figure_is_drawn(paper, made_up, tmp_path):
    write_figures(paper.figures, made_up(paper), tmp_path, "swarm-forage reproduce x")
    names = FIGURES[paper.name]
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(
        f"{name}{ending}" for name in names for ending in (".png", ".png.json", ".svg", ".svg.json")
    )
    for file in tmp_path.glob("*.svg"):
        assert "swarm-forage reproduce x" in file.read_text("utf-8")


def test_the_page_holds_table_figures_command_and_what_is_left_open(paper, made_up):
    results = made_up(paper)
    claim_results = paper.judge(results)
    text = report.page(paper, claim_results, results, "swarm-forage reproduce x --seed=0")
    assert "swarm-forage reproduce x --seed=0" in text
    if paper.name not in {"robustness", "transfer"}:  # have a table in the place of a score
        assert report.score(claim_results) in text
    for each in claim_results:
        assert f"| {each.claim} |" in text
    for name in FIGURES[paper.name]:
        assert f"(figures/{name}.png)" in text
    for figure in paper.figures:
        assert f"*{figure.caption} {figure.reading}".strip() + "*" in text
    assert "Not in the paper" in text
    assert "$" not in text


def test_the_terminal_shows_the_verdicts(paper, made_up):
    claim_results = paper.judge(made_up(paper))
    console = Console(file=io.StringIO(), width=80)
    console.print(report.claims_table(claim_results))
    shown = console.file.getvalue()
    assert f"of {len(claim_results)} claims reproduced" in shown
    assert "…" not in shown
