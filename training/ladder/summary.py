"""What the runs say: interquartile means with intervals, normalised scores, times."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from baselines.evaluation.statistics import Estimate, iqm_interval
from swarm_forage_env.task import task_of
from training.ladder.rungs import Rung
from training.ladder.runs import Run


@dataclass(frozen=True)
class Row:
    """An algorithm on a rung."""

    algorithm: str
    score: Estimate
    """Interquartile mean over the runs, each the mean of its test episodes."""
    normalised: float
    seeds: int
    robot_steps: int
    train_s: float
    """Median wall-clock time of a training [s]."""


def by_algorithm(runs: Sequence[Run]) -> dict[str, list[Run]]:
    """The runs of each algorithm."""
    found: dict[str, list[Run]] = {}
    for run in runs:
        found.setdefault(run.algorithm, []).append(run)
    return found


def by_rung(rungs: Sequence[Rung], runs: Sequence[Run]) -> dict[str, list[Run]]:
    """The runs of each rung that has any, the easiest first."""
    found = {rung.name: [run for run in runs if run.rung == rung.name] for rung in rungs}
    return {name: own for name, own in found.items() if own}


def rows_of(rung: Rung, runs: Sequence[Run]) -> list[Row]:
    """The algorithms on a rung, the best first."""
    found = []
    for algorithm, own in by_algorithm(runs).items():
        score = iqm_interval([[run.score for run in own]])
        assert score is not None
        found.append(
            Row(
                algorithm,
                score,
                rung.normalised(score.value),
                len(own),
                max(run.robot_steps for run in own),
                float(np.median([run.train_s for run in own])),
            )
        )
    return sorted(found, key=lambda row: -row.score.value)


def strata_of(rungs: Sequence[Rung], runs: Sequence[Run]) -> list[list[float]]:
    """Normalised scores of the runs of each rung."""
    groups = by_rung(rungs, runs)
    return [
        [rung.normalised(run.score) for run in groups[rung.name]]
        for rung in rungs
        if rung.name in groups
    ]


def over_all(rungs: Sequence[Rung], runs: Sequence[Run]) -> Mapping[str, tuple[Estimate, int]]:
    """Of each algorithm the interquartile mean of all normalised scores, and of how many rungs."""
    found = {}
    for algorithm, own in by_algorithm(runs).items():
        strata = strata_of(rungs, own)
        estimate = iqm_interval(strata)
        assert estimate is not None
        found[algorithm] = estimate, len(strata)
    return dict(sorted(found.items(), key=lambda each: (-each[1][1], -each[1][0].value)))


def score_word(rung: Rung) -> str:
    """What is counted."""
    words: str = task_of(rung.test_scenario).episode.score_words
    return words
