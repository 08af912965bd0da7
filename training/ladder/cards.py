"""The cards of the ladder: scores of random actions, controllers and oracles; for a terminal."""

import textwrap
from collections.abc import Sequence
from pathlib import Path

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.evaluation.backends import Backend
from baselines.evaluation.console import say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.runner import Plan, run_with_progress
from baselines.evaluation.statistics import mean_interval
from baselines.evaluation.tables import scores
from swarm_forage_env.task import task_of
from training.ladder.play import play, random_actions, seeds_of_tests
from training.ladder.rungs import RANDOM, Algorithm, Rung, Score, write_scores


def score_references(rung: Rung, out: Path, backend: Backend) -> dict[str, Score]:
    """Score what a rung's card names, and write it into the rung's file.

    Episodes are kept in a dataset: a command that was stopped goes on from there.
    """
    seeds = seeds_of_tests(rung.card.episodes)
    keywords = rung.test_keywords
    say(f"{rung.name}: random actions, {len(seeds)} episodes")
    results = {RANDOM: _score(play(keywords, random_actions(keywords), seeds))}
    scenario, dataset = rung.test_scenario, Dataset(out)
    physics = task_of(scenario).physics
    dataset.open()
    configurations = [
        ExperimentConfig(name, scenario, find_layered_controller(name), physics)
        for name in rung.references
    ]
    plan = Plan(configurations, seeds, dataset)
    run_with_progress(plan, backend)
    for name, episodes in zip(rung.references, plan.by_configuration(), strict=True):
        results[name] = _score(scores(episodes))
    write_scores(rung, results)
    return results


def _score(values: Sequence[float]) -> Score:
    estimate = mean_interval(values)
    assert estimate is not None
    low, high = estimate.interval or (None, None)
    return Score(mean=estimate.value, low=low, high=high, episodes=estimate.n)


def tables(rungs: Sequence[Rung], algorithms: Sequence[Algorithm]) -> Group:
    """Every rung with its scores and what is hard, then the algorithms."""
    parts: list[Text | Table] = []
    for rung in rungs:
        card = rung.card
        parts.append(Text(f"{card.rung} {rung.name}", style="bold").append(f"  {card.title}"))
        parts.append(Text(textwrap.fill(card.hard, 78)))
        named = [name for name in (RANDOM, *rung.references) if name in card.scores]
        listed = ", ".join(f"{name} {card.scores[name].mean:.1f}" for name in named)
        parts += [Text(listed or "no scores yet: swarm-forage benchmark cards"), Text()]
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("algorithm", "", "trained by"):
        table.add_column(heading)
    for each in algorithms:
        table.add_row(each.name, each.title, each.trainer)
    return Group(*parts, table)
