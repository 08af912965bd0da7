"""Search the numbers that the papers leave open, by approximate Bayesian computation.

A set is measured in es1, without communication and with SGIKF. Its distance is the largest by
which it misses a published number, in tolerances of that number. It goes on to the other filters,
and to es2, while its distance is small (`STAGES`).

Later sets are drawn around the nearest so far (`population`), with weights by which all of them
stand for the prior, and those within a distance for the posterior.

Source: TR, Section 6 (published numbers).
Not in the paper:
- a tolerance is twice the standard error of the difference between a mean of 30 episodes and ours,
  with what the printed number is rounded by;
- four worlds of es1, one of es2, the same for all sets, under the engine `kinematic`; who is far
  from es1 in the first of these, by one and a half tolerances, is not measured in the others.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.stats import qmc

from baselines.evaluation.console import say
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.papers.experiments import Experiment, Metric, on_path, recruitment_time, round_trips
from baselines.papers.open_prior import PRIOR, Value, configuration, place_of, today, values_of
from baselines.papers.population import FIRST, Draws, densities_of
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.loop import Loop

BATCH, THREADS = 32, 2
"""Sets measured at a time, after which all are kept; threads that they are shared among."""

BEYOND = 1000.0
"""Sets outside the tolerances of es1 are farther by this than all others, and those that one world
showed to be so by twice this."""

SINGLES, DOUBLES = (1e-4, 1e-3, 1e-2, 1e-1), (1e-3, 1e-2)
"""Betas of SSGIFF and DSGIFF that a set is measured with."""

OTHERS = ("dsgikf", *(f"ssgiff:beta={each:g}" for each in SINGLES),
          *(f"dsgiff:beta={each:g}" for each in DOUBLES))  # fmt: skip
STAGES = (
    ("es1", ("nc", "ssgikf"), range(7000, 7001), 1.5),
    ("es1", ("nc", "ssgikf"), range(7001, 7004), 1.0),
    ("es1", OTHERS, range(7000, 7004), 1.0),
    ("es2", ("nc", "ssgikf"), range(7000, 7001), 3.0),
    ("es2", OTHERS, range(7000, 7001), 0.0),
)
"""Arena, controllers and worlds of each stage, and the largest distance that goes on from it."""

PUBLISHED: Mapping[str, Mapping[str, tuple[float, float, float, float]]] = {
    "es1": {
        "round trips, NC": (60.0, 60.0, 10.5, 2.5),
        "round trips, SGIKF": (150.0, 150.0, 12.0, 5.0),
        "on the path, NC": (0.0, 0.2, 0.056, 0.0),
        "on the path, SGIKF": (0.5, 0.7, 0.056, 0.0),
        "times faster recruitment": (4.0, 4.0, 2.0, 0.5),
        "round trips, best SGIFF": (170.0, 170.0, 12.0, 5.0),
    },
    "es2": {
        "round trips, NC": (0.0, 50.0, 5.3, 0.0),
        "round trips, SGIKF": (1400.0, 1400.0, 32.0, 50.0),
        "on the path, NC": (0.0, 0.2, 0.025, 0.0),
        "on the path, SGIKF": (0.5, 0.7, 0.016, 0.0),
        "times faster recruitment": (4.0, 4.0, 0.5, 0.5),
    },
}
"""Ends of what TR 6 says, the standard deviation between episodes of today's set, and half of the
last digit that is printed; in the order of `numbers_of`."""


@dataclass(frozen=True)
class Measured:
    """An episode of a set: what claims ask of it."""

    arena: str
    controller: str
    round_trips: int
    on_path_share: float
    recruitment_time_s: float | None
    duration_s: float


def measure(
    sets: Sequence[Mapping[str, Value]], arena: str, controllers: Sequence[str], seeds: range
) -> list[list[Measured]]:
    """Run the episodes of each controller for each set, those of one compilation side by side."""
    found: list[list[Measured]] = [[] for _ in sets]
    jobs = [(k, each, configuration(Experiment(arena, each), values))
            for k, values in enumerate(sets) for each in controllers]  # fmt: skip

    def compilation(job: tuple[int, str, ExperimentConfig]) -> tuple[str, int]:
        return type(job[2].controller.weighting).__name__, job[2].scenario.radio.slots

    for _, alike in groupby(sorted(jobs, key=compilation), compilation):
        group = [(*job, seed) for job in alike for seed in seeds]
        scenarios, worlds = [job[2].scenario for job in group], [job[3] for job in group]
        loop = Loop(scenarios, [job[2].controller for job in group], worlds, "kinematic", THREADS)
        meter = loop.task.episode.meter(loop)
        loop.run(scenarios[0].n_ticks)
        results: list[dict[str, Any]] = meter.results()
        for (k, controller, config, _), each in zip(group, results, strict=True):
            trips, share = each["round_trips"], round(each["on_path_share"], 4)
            recruited, duration = each["recruitment_time_s"], config.scenario.task.duration
            found[k].append(Measured(arena, controller, trips, share, recruited, duration))
    return found


def numbers_of(episodes: Sequence[Measured], arena: str) -> list[float]:
    """Ours of each published number, in their order; NaN for what was not measured."""

    def mean(metric: Metric, controller: str) -> float:
        own = [each for each in episodes if (each.arena, each.controller) == (arena, controller)]
        return float(np.mean([metric(cast(Any, each)) for each in own])) if own else math.nan

    times = [mean(recruitment_time, each) for each in ("nc", "ssgikf")]
    best = max(mean(round_trips, each) for each in OTHERS[1 : 1 + len(SINGLES)])
    numbers = [mean(metric, each) for metric in (round_trips, on_path) for each in ("nc", "ssgikf")]
    return [*numbers, times[0] / times[1], best]


def n_worlds(episodes: Sequence[Measured], arena: str) -> int:
    """In how many worlds of an arena a set was measured."""
    return sum((each.arena, each.controller) == (arena, "nc") for each in episodes)


def distance(episodes: Sequence[Measured], arena: str) -> float:
    """The largest miss of a published number, in its tolerances; infinite if not measured."""
    n = n_worlds(episodes, arena)
    if not n:
        return math.inf
    misses = [0.0]
    ours_of = zip(numbers_of(episodes, arena), PUBLISHED[arena].values(), strict=False)
    for ours, (low, high, spread, rounding) in ours_of:
        error = math.sqrt(spread**2 * (1.0 / 30.0 + 1.0 / n) + rounding**2 / 3.0)
        misses += [max(low - ours, ours - high) / (2.0 * error)] * (not math.isnan(ours))
    return max(misses)


def farness(episodes: Sequence[Measured]) -> float:
    """What sets are ordered by: the distance of es1, and within its tolerances that of es2."""
    far = distance(episodes, "es1")
    if far <= 1.0:
        return min(distance(episodes, "es2"), BEYOND)
    return far + BEYOND * (2.0 if n_worlds(episodes, "es1") == 1 else 1.0)


def measure_all(sets: Sequence[Mapping[str, Value]], is_whole: bool) -> list[list[Measured]]:
    """Take sets through the stages, each while it is near, or all the way."""
    found: list[list[Measured]] = [[] for _ in sets]
    going = list(range(len(sets)))
    for arena, controllers, seeds, limit in STAGES:
        measured = measure([sets[k] for k in going], arena, controllers, seeds)
        for k, episodes in zip(going, measured, strict=True):
            found[k] += episodes
        going = [k for k in going if is_whole or distance(found[k], arena) <= limit]
    return found


def load(file: Path) -> pa.Table:
    """The sets so far: their places in the unit cube, their numbers, their episodes."""
    return pq.read_table(file) if file.exists() else pa.table({})


def episodes_in(table: pa.Table) -> list[list[Measured]]:
    """The episodes of each set."""
    rows = table["episodes"].to_pylist() if table.num_rows else []
    return [[Measured(**each) for each in row] for row in rows]


def draws_in(table: pa.Table) -> Draws:
    """The place of each set in the unit cube."""
    rows = table["draw"].to_pylist() if table.num_rows else []
    return np.asarray(np.array(rows, float).reshape(-1, len(PRIOR)))


def next_draws(draws: Draws, far: Float64[Array, " sets"], seed: int) -> Draws:
    """The sets to measure next; the first of all is today's."""
    done = len(draws)
    if done == 0:
        return np.array([place_of(today())])
    if done < FIRST:
        even = qmc.Sobol(len(PRIOR), seed=seed).random(FIRST)
        return np.asarray(even[done : done + BATCH])
    return densities_of(draws, far)[-1].draw(BATCH, np.random.default_rng((seed, done)))


def search(file: Path, n_sets: int, seed: int) -> None:
    """Draw and measure sets until the file holds `n_sets`."""
    table = load(file)
    draws, far = draws_in(table), np.array([farness(each) for each in episodes_in(table)])
    while len(draws) < n_sets:
        new = next_draws(draws, far, seed).astype(np.float32).astype(float)
        sets = [values_of(each) for each in new]
        found = measure_all(sets, is_whole=len(draws) == 0)
        rows = [{"draw": draw.tolist(), **values, "episodes": [asdict(each) for each in episodes]}
                for draw, values, episodes in zip(new, sets, found, strict=True)]  # fmt: skip
        tables = [table, pa.Table.from_pylist(rows)][not len(draws) :]
        table, content = pa.concat_tables(tables, promote_options="permissive"), BytesIO()
        pq.write_table(table, content, compression="zstd")
        write_atomically(file, content.getvalue())
        draws = np.concatenate([draws, new])
        far = np.concatenate([far, [farness(each) for each in found]])
        near = [int((far <= limit).sum()) for limit in (BEYOND, 1.0)]
        say(f"{len(far)} sets, {near[0]} within the tolerances of es1, {near[1]} of es2 too")
