"""The papers: their claims are all there, and a run of made-up episodes becomes a page."""

import dataclasses
import importlib
import io
import json
import pkgutil
import re
from pathlib import Path

import pytest
from rich.console import Console

import baselines.papers
from baselines.evaluation import statistics
from baselines.papers import report
from baselines.papers.commands_reproduce import PAPER_NAMES
from baselines.papers.figures import write_figures
from baselines.papers.paper import find_paper

PAGES = Path(baselines.__file__).parents[1] / "docs" / "papers"


@pytest.fixture(params=PAPER_NAMES)
def paper(request):
    return find_paper(request.param)


def claims_of(text):
    """Claim and published value of each row of the table of claims."""
    rows = text.partition("| claim |")[2].partition("\n\n")[0].splitlines()[2:]
    return [row.split(" | ")[:2] for row in rows]


def row_of(claim):
    """How the row of a claim begins; the row of an order of layers is one of ratios."""
    return f"| {re.sub(', every (motion|estimator)$', '', claim.text)} |"


def test_the_page_that_is_kept_has_every_claim_once_with_what_is_published(paper, made_up):
    kept = (PAGES / f"{paper.page}.md").read_text("utf-8")
    claim_results = paper.judge(made_up(paper))
    if "| claim |" in kept:
        assert claims_of(kept) == claims_of(report.claims_markdown(claim_results))
    rows = {row_of(claim) for claim in paper.claims}
    assert len(rows) == len(paper.claims)
    assert all(row in kept for row in rows)
    for figure in paper.figures:
        assert f"![{figure.caption}](figures/{figure.name}.png)" in kept
    for each in json.loads(report.to_json(claim_results)):
        assert set(each) == {"claim", "published", "ours", "low", "high", "reproduced"}


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
    assert {each.scenario.task.duration for each in configurations} == {10.0}
    assert all(each.controller.supports(each.scenario) for each in configurations)


def test_every_figure_is_drawn(paper, made_up, tmp_path):
    write_figures(paper.figures, made_up(paper), tmp_path, "swarm-forage reproduce x")
    names = [figure.name for figure in paper.figures]
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
    if paper.name not in {"robustness", "transfer", "boids-foraging"}:  # have a table instead
        assert report.score(claim_results) in text
    for claim in paper.claims:
        assert row_of(claim) in text
    for figure in paper.figures:
        assert f"(figures/{figure.name}.png)" in text
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
