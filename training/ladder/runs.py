"""Runs of the ladder, one for each rung, algorithm and seed, stored as rows of a Parquet file.

The file is written atomically after each run, so that a benchmark killed at any moment resumes with
the missing runs; an unfinished run is lost. The runs on docs/ladder.md are in the repository.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from itertools import product
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from baselines.evaluation.dataset import DamagedFileError, read_table
from baselines.evaluation.statistics import Estimate, iqm_interval, probability_of_improvement
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.task import task_of
from training.ladder.play import Point
from training.ladder.rungs import Algorithm, Rung

AS_JSON = ("config", "versions")
"""Nested fields, which the Parquet file stores as JSON."""

PACKAGES = ("swarm-forage", "numpy", "numba", "torch", "stable-baselines3", "torchrl", "benchmarl")


@dataclass(frozen=True)
class Job:
    """Training that is to be run."""

    rung: Rung
    algorithm: Algorithm
    seed: int
    budget: int | None = None  # robot-steps; None: the rung's times the algorithm's share

    @property
    def robot_steps(self) -> int:
        """Length of the training, summed over robots [ticks]."""
        return self.budget or round(self.rung.card.robot_steps * self.algorithm.share)

    @property
    def config(self) -> dict[str, object]:
        """Configuration of the run, without its seed and length."""
        card = self.rung.card
        return {
            "keywords": dict(self.rung.keywords),
            "world": self.rung.test_scenario.model_dump(mode="json"),
            "test": self.rung.test_keywords,
            "episodes": [card.curve_episodes, card.episodes],
            "algorithm": self.algorithm.model_dump(
                exclude={"title", "share", "rungs"}, exclude_defaults=True
            ),
        }

    @cached_property
    def key(self) -> str:
        """Hash of the configuration."""
        text = json.dumps(self.config, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


@dataclass(frozen=True)
class Run:
    """Result of a job."""

    rung: str
    algorithm: str
    seed: int
    key: str
    config: Mapping[str, object]
    robot_steps: int  # length of the training, summed over robots [ticks]
    train_s: float  # wall-clock time of the training, without evaluations [s]
    curve: Sequence[Point]  # evaluations on held-back seeds
    scores: Sequence[float]  # test scores of the best of these policies, deterministic
    scores_by_chance: Sequence[float]  # test scores of this policy, stochastic as in training
    versions: Mapping[str, str]
    scores_kinematic: Sequence[float] = field(default_factory=list)
    """`scores` under the engine `kinematic`; none of runs made before these were taken."""
    scores_kinematic_by_chance: Sequence[float] = field(default_factory=list)

    @property
    def identity(self) -> tuple[str, str, int]:
        """Rung, algorithm and seed, which identify a run."""
        return self.rung, self.algorithm, self.seed

    @property
    def score(self) -> float:
        """Mean score over the test episodes."""
        return float(np.mean(self.scores))

    @property
    def score_by_chance(self) -> float:
        """Mean score of the stochastic policy over the test episodes."""
        return float(np.mean(self.scores_by_chance))


def find(job: Job, runs: Sequence[Run]) -> Run | None:
    """Return the run of a job, with its configuration and length; None if there is none."""
    wanted = (job.rung.name, job.algorithm.name, job.seed, job.key, job.robot_steps)
    return next((run for run in runs if (*run.identity, run.key, run.robot_steps) == wanted), None)


def current(
    runs: Sequence[Run], rungs: Sequence[Rung], algorithms: Sequence[Algorithm]
) -> list[Run]:
    """Return the runs of the present configurations, the longest one of each seed."""
    counted: list[Run] = []
    for rung, algorithm in product(rungs, algorithms):
        wanted = (rung.name, algorithm.name, Job(rung, algorithm, 0).key)
        alike = [run for run in runs if (*run.identity[:2], run.key) == wanted]
        longest = {run.seed: run for run in sorted(alike, key=lambda run: run.robot_steps)}
        counted += [longest[seed] for seed in sorted(longest)]
    return counted


def read_runs(file: Path) -> list[Run]:
    """Read the runs of a Parquet file; none without a file. ConfigError if it holds no runs."""
    if not file.exists():
        return []
    try:
        rows = read_table(file.read_bytes()).to_pylist()
        return [Run(**row | {name: json.loads(row[name]) for name in AS_JSON}) for row in rows]
    except (DamagedFileError, KeyError, TypeError, ValueError):
        raise ConfigError(f"{file}: holds no runs of the ladder; move it away") from None


SCORES = pa.list_(pa.float64())
POINT = {"robot_steps": pa.int64(), "wall_s": pa.float64(), "scores": SCORES}
COLUMN_TYPES = {
    int: pa.int64(),
    float: pa.float64(),
    Sequence[float]: SCORES,
    Sequence[Point]: pa.list_(pa.struct(POINT)),
}
"""Type of the columns of the Parquet file by that of the field of a run; text for all others."""


def write_runs(runs: Sequence[Run], file: Path) -> None:
    """Write runs to a Parquet file, atomically."""
    kinds = get_type_hints(Run).items()
    columns = pa.schema({name: COLUMN_TYPES.get(kind, pa.string()) for name, kind in kinds})
    rows = [vars(run) | {name: json.dumps(vars(run)[name]) for name in AS_JSON} for run in runs]
    content = pa.BufferOutputStream()
    table = pa.Table.from_pylist(rows, columns)
    pq.write_table(table, content, compression="zstd", write_page_checksum=True)
    write_atomically(file, content.getvalue().to_pybytes())


def add_run(run: Run, file: Path) -> None:
    """Add a run to a Parquet file, in place of runs of the same identity that are not longer."""
    others = [
        each
        for each in read_runs(file)
        if each.identity != run.identity or each.robot_steps > run.robot_steps
    ]
    write_runs([*others, run], file)


def versions() -> dict[str, str]:
    """Return the versions of the packages that a run depends on."""
    installed = {}
    for package in PACKAGES:
        with suppress(PackageNotFoundError):
            installed[package] = version(package)
    return installed


def marl_eval(runs: Sequence[Run]) -> dict[str, object]:
    """Return the runs as marl-eval reads them: by rung, algorithm, seed and evaluation.

    Source: Gorsane et al. 2022.
    """
    tree: dict[str, dict[str, dict[str, object]]] = {}
    for run in runs:
        seeds = tree.setdefault(run.rung, {}).setdefault(run.algorithm, {})
        steps: dict[str, object] = {
            f"step_{k}": {
                "step_count": point["robot_steps"],
                "elapsed_time": point["wall_s"],
                "score": point["scores"],
            }
            for k, point in enumerate(run.curve)
        }
        seeds[f"seed_{run.seed}"] = {**steps, "absolute_metrics": {"score": [run.score]}}
    return {"swarm_forage": tree}


def by_algorithm(runs: Sequence[Run]) -> dict[str, list[Run]]:
    """Group runs by algorithm."""
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.algorithm, []).append(run)
    return groups


def by_rung(rungs: Sequence[Rung], runs: Sequence[Run]) -> list[tuple[Rung, list[Run]]]:
    """Group runs by rung, in the order of the rungs; rungs without runs are left out."""
    pairs = ((rung, [run for run in runs if run.rung == rung.name]) for rung in rungs)
    return [(rung, group) for rung, group in pairs if group]


def iqm(strata: Sequence[Sequence[float]]) -> Estimate:
    """Return the interquartile mean of scores; each stratum has one or more."""
    estimate = iqm_interval(strata)
    assert estimate is not None
    return estimate


def strata_of(rungs: Sequence[Rung], runs: Sequence[Run]) -> list[list[float]]:
    """Return the normalised scores of the runs of each rung."""
    return [[rung.normalised(run.score) for run in group] for rung, group in by_rung(rungs, runs)]


def over_all(rungs: Sequence[Rung], runs: Sequence[Run]) -> Mapping[str, tuple[Estimate, int]]:
    """Return each algorithm's interquartile mean of normalised scores and number of rungs."""
    estimates = {}
    for algorithm, group in by_algorithm(runs).items():
        strata = strata_of(rungs, group)
        estimates[algorithm] = iqm(strata), len(strata)
    return dict(sorted(estimates.items(), key=lambda each: (-each[1][1], -each[1][0].value)))


def improvements(
    rungs: Sequence[Rung], runs: Sequence[Run], base: str
) -> dict[str, tuple[Estimate, int]]:
    """Return each algorithm's probability that its run beats one of `base` on the same rung.

    The second value is the number of rungs that both share; algorithms that share none are left
    out.
    """
    groups = by_algorithm(runs)
    probabilities = {}
    for algorithm, group in groups.items():
        names = {run.rung for run in group} & {run.rung for run in groups[base]}
        shared = [rung for rung in rungs if rung.name in names]
        if algorithm != base and shared:
            strata = strata_of(shared, group), strata_of(shared, groups[base])
            probabilities[algorithm] = probability_of_improvement(*strata), len(shared)
    return probabilities


def score_word(rung: Rung) -> str:
    """Return the name of the score of a rung's task in words."""
    words: str = task_of(rung.test_scenario).episode.score_words
    return words
