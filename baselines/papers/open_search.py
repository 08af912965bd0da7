"""Search the numbers that the papers leave open, by approximate Bayesian computation.

A set is measured in es1, without communication and with SGIKF. Its distance is the largest
deviation from a published number, in tolerances of that number. While the distance is small, the
set is measured with the other filters and in es2 (`STAGES`).

After the first sets, which fill the prior evenly, an emulator of all sets so far gives the
probability of a set to lie within the tolerances (`fit_emulator`): later draws are weighted by it.

Source: TR, Section 6 (published numbers); Wood2010 (emulated likelihood).

Not in the paper:
- a tolerance is twice the standard error of the difference between a mean of 30 episodes and ours,
  with what the printed number is rounded by;
- four worlds of es1, one of es2, the same for all sets, under the engine `kinematic`; a set far
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
from scipy.stats import norm, qmc

from baselines.evaluation.console import say
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.papers.experiments import Experiment, Metric, on_path, recruitment_time, round_trips
from baselines.papers.open_prior import PRIOR, Value, configuration, place_of, today, values_of
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.loop import Loop

Draws = Float64[Array, "draws numbers"]  # points of the unit cube, where the prior is uniform

BATCH, THREADS = 32, 2  # sets measured before each save; number of threads that measure them

FIRST, EVEN, CANDIDATES, FEWEST = 256, 0.1, 20_000, 32
"""Sets before the first emulator; share of the later sets drawn from the plain prior; draws of the
prior among which the others are chosen; least number of sets that an emulator is fitted to."""

PENALTY, FOLDS = 10.0, 8
"""Ridge penalty of the regression; folds of the cross-validation of its error."""

SINGLES, DOUBLES = (1e-4, 1e-3, 1e-2, 1e-1), (1e-3, 1e-2)
"""Betas of SSGIFF and DSGIFF with which a set is measured."""

OTHERS = ("dsgikf", *(f"ssgiff:beta={each:g}" for each in SINGLES),
          *(f"dsgiff:beta={each:g}" for each in DOUBLES))  # fmt: skip
STAGES = (
    ("es1", ("nc", "ssgikf"), range(7000, 7001), 1.5),
    ("es1", ("nc", "ssgikf"), range(7001, 7004), 1.0),
    ("es1", OTHERS, range(7000, 7004), 1.0),
    ("es2", ("nc", "ssgikf"), range(7000, 7001), 6.0),
    ("es2", OTHERS, range(7000, 7001), 0.0),
)
"""Arena, controllers and worlds of each stage, and the largest distance that passes it."""

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
"""Ends of the range in TR 6, standard deviation between episodes of today's set, and half of the
last printed digit; in the order of `numbers_of`."""


@dataclass(frozen=True)
class Measured:
    """Episode of a set: the fields that the claims use."""

    arena: str
    controller: str
    n_robots: int
    round_trips: int
    on_path_share: float
    recruitment_time_s: float | None
    duration_s: float


def measure(
    sets: Sequence[Mapping[str, Value]], experiments: Sequence[Experiment], seeds: range
) -> list[list[Measured]]:
    """Run the episodes of each experiment for each set; those of one compilation run together."""
    episodes: list[list[Measured]] = [[] for _ in sets]
    jobs = [(k, each, configuration(each, values))
            for k, values in enumerate(sets) for each in experiments]  # fmt: skip

    def compilation(job: tuple[int, Experiment, ExperimentConfig]) -> tuple[str, str, int, int]:
        scenario, own = job[2].scenario, job[2].controller
        layers = type(own.estimator).__name__, type(own.weighting).__name__
        return *layers, scenario.radio.slots, scenario.task.n_robots

    for _, alike in groupby(sorted(jobs, key=compilation), compilation):
        group = [(*job, seed) for job in alike for seed in seeds]
        scenarios, worlds = [job[2].scenario for job in group], [job[3] for job in group]
        loop = Loop(scenarios, [job[2].controller for job in group], worlds, "kinematic", THREADS)
        meter = loop.task.episode.meter(loop)
        loop.run(scenarios[0].n_ticks)
        results: list[dict[str, Any]] = meter.results()
        for (k, of, config, _), each in zip(group, results, strict=True):
            trips, share = each["round_trips"], round(each["on_path_share"], 4)
            task, recruited = config.scenario.task, each["recruitment_time_s"]
            numbers = trips, share, recruited, task.duration
            episodes[k].append(Measured(of.scenario, of.controller, task.n_robots, *numbers))
    return episodes


def numbers_of(episodes: Sequence[Measured], arena: str) -> list[float]:
    """Return our value of each published number, in their order; NaN if not measured."""

    def mean(metric: Metric, controller: str) -> float:
        own = [each for each in episodes if (each.arena, each.controller) == (arena, controller)]
        return float(np.mean([metric(cast(Any, each)) for each in own])) if own else math.nan

    times = [mean(recruitment_time, each) for each in ("nc", "ssgikf")]
    best = max(mean(round_trips, each) for each in OTHERS[1 : 1 + len(SINGLES)])
    numbers = [mean(metric, each) for metric in (round_trips, on_path) for each in ("nc", "ssgikf")]
    return [*numbers, times[0] / times[1], best]


def n_worlds(episodes: Sequence[Measured], arena: str) -> int:
    """Return in how many worlds of an arena a set was measured."""
    return sum((each.arena, each.controller) == (arena, "nc") for each in episodes)


def tolerance(spread: float, rounding: float, n: int) -> float:
    """Return twice the standard error of the difference of a printed mean of 30 and one of n."""
    return 2.0 * math.sqrt(spread**2 * (1.0 / 30.0 + 1.0 / n) + rounding**2 / 3.0)


def distance(episodes: Sequence[Measured], arena: str) -> float:
    """Return the largest deviation from a published number, in tolerances; inf if not measured."""
    n = n_worlds(episodes, arena)
    if not n:
        return math.inf
    misses = [0.0]
    ours_of = zip(numbers_of(episodes, arena), PUBLISHED[arena].values(), strict=False)
    for ours, (low, high, spread, rounding) in ours_of:
        miss = max(low - ours, ours - high) / tolerance(spread, rounding, n)
        misses += [miss] * (not math.isnan(ours))
    return max(misses)


def measure_all(sets: Sequence[Mapping[str, Value]], is_whole: bool) -> list[list[Measured]]:
    """Measure sets stage by stage, each while its distance is small or, if `is_whole`, in all."""
    episodes_of: list[list[Measured]] = [[] for _ in sets]
    going = list(range(len(sets)))
    for arena, controllers, seeds, limit in STAGES:
        experiments = [Experiment(arena, each) for each in controllers]
        measured = measure([sets[k] for k in going], experiments, seeds)
        for k, episodes in zip(going, measured, strict=True):
            episodes_of[k] += episodes
        going = [k for k in going if is_whole or distance(episodes_of[k], arena) <= limit]
    return episodes_of


def load(file: Path) -> pa.Table:
    """Read the sets so far: points of the unit cube, values, episodes; empty without a file."""
    return pq.read_table(file) if file.exists() else pa.table({})


def save(file: Path, table: pa.Table) -> None:
    """Write the sets so far to the file."""
    content = BytesIO()
    pq.write_table(table, content, compression="zstd")
    write_atomically(file, content.getvalue())


def sets_of(table: pa.Table) -> tuple[Draws, list[list[Measured]]]:
    """Return the point of each set in the unit cube, and its episodes."""
    rows = table.select(["draw", "episodes"]).to_pylist() if table.num_rows else []
    draws = np.array([row["draw"] for row in rows], float).reshape(-1, len(PRIOR))
    return draws, [[Measured(**each) for each in row["episodes"]] for row in rows]


Emulator = tuple[Float64[Array, "terms outputs"], Float64[Array, " outputs"]]
"""Coefficients of a regression, and standard deviations of the outputs about it."""


def fit_emulator(
    draws: Draws, outputs: Float64[Array, "draws outputs"], weights: Float64[Array, " draws"]
) -> Emulator:
    """Fit an emulator: quadratic regression of the outputs of a simulation, with weighted draws.

    Its error is that of points that it was not fitted to, and thus includes the noise of the
    simulation.

    Source: Wood2010 (likelihood from simulated summaries), HoerlKennard1970 (ridge regression).

    Not in the papers: the penalty, eight folds, and errors of the numbers that are normal and apart.
    """  # noqa: E501 as on the page
    x, fold = quadratic_terms(draws), np.arange(len(draws)) % FOLDS
    residuals = np.empty_like(outputs)
    for k in range(FOLDS):
        out, rest = fold == k, fold != k
        residuals[out] = outputs[out] - x[out] @ ridge(x[rest], outputs[rest], weights[rest])
    return ridge(x, outputs, weights), np.sqrt(weights @ residuals**2 / weights.sum())


def probability_within(
    draws: Draws,
    fitted: Emulator,
    low: Float64[Array, " outputs"],
    high: Float64[Array, " outputs"],
) -> Float64[Array, " draws"]:
    """Return the probability at each point that every output lies between its ends."""
    coefficients, errors = fitted
    means = quadratic_terms(draws) @ coefficients
    below, above = (norm.cdf((ends - means) / errors) for ends in (low, high))
    return np.asarray((above - below).prod(axis=1))


def quadratic_terms(draws: Draws) -> Float64[Array, "draws terms"]:
    """Return one, each number, and each product of two, with numbers scaled to [-1, 1]."""
    x = 2.0 * draws - 1.0
    one, other = np.triu_indices(x.shape[1])
    return np.column_stack([np.ones(len(x)), x, x[:, one] * x[:, other]])


def ridge(
    x: Float64[Array, "draws terms"],
    outputs: Float64[Array, "draws outputs"],
    weights: Float64[Array, " draws"],
) -> Float64[Array, "terms outputs"]:
    """Return the coefficients of a weighted ridge regression, its constant without penalty.

    (X' W X + l I) b = X' W y
    """
    penalty = PENALTY * np.eye(x.shape[1])
    penalty[0, 0] = 0.0
    weighted = x.T * weights
    return np.asarray(np.linalg.solve(weighted @ x + penalty, weighted @ outputs))


def inputs(draws: Draws, arena: str) -> Draws:
    """Return the inputs of an arena: all but the areas of other arenas; rules as 0 or 1."""
    bears = [not name.endswith("area_distance") or name.startswith(arena) for name in PRIOR]
    is_rule = np.array([isinstance(each, tuple) for each in PRIOR.values()])
    return np.asarray(np.where(is_rule, draws >= 0.5, draws)[:, bears])


def scaled(numbers: Float64[Array, "sets numbers"]) -> Float64[Array, "sets 5"]:
    """Return the first five published numbers for an emulator: counts and ratio as logarithms."""
    counts = np.log(np.maximum(numbers[:, [0, 1, 4]], 1e-3))
    return np.column_stack([counts, numbers[:, 2:4]])


def probabilities(
    candidates: Draws, draws: Draws, episodes: Sequence[Sequence[Measured]], arena: str
) -> Float64[Array, " candidates"]:
    """Return the probability that sets lie within the tolerances of an arena, by an emulator.

    The emulator is fitted to all sets measured there; below `FEWEST` sets, the result is 1.
    """
    n = np.array([n_worlds(each, arena) for each in episodes])
    if (n > 0).sum() < FEWEST:
        return np.ones(len(candidates))
    numbers = np.array([numbers_of(e, arena) for e, k in zip(episodes, n, strict=True) if k])
    fitted = fit_emulator(inputs(draws[n > 0], arena), scaled(numbers), n[n > 0].astype(float))
    ends = [
        (low - (near := tolerance(spread, rounding, int(n.max()))), high + near)
        for low, high, spread, rounding in PUBLISHED[arena].values()
    ]
    return probability_within(inputs(candidates, arena), fitted, *scaled(np.array(ends).T))


def next_draws(draws: Draws, episodes: Sequence[Sequence[Measured]], seed: int) -> Draws:
    """Return the sets to measure next; the very first one is today's."""
    done = len(draws)
    if done == 0:
        return np.array([place_of(today())])
    if done < FIRST:
        return np.asarray(qmc.Sobol(len(PRIOR), seed=seed).random(FIRST)[done : done + BATCH])
    rng = np.random.default_rng((seed, done))
    candidates = rng.random((CANDIDATES, len(PRIOR)))
    each = [probabilities(candidates, draws, episodes, arena) for arena in ("es1", "es2")]
    weights = each[0] * each[1]
    weights += np.finfo(float).tiny  # for the case that no set has a probability above zero
    n_even = round(EVEN * BATCH)
    chosen = rng.choice(CANDIDATES, BATCH - n_even, replace=False, p=weights / weights.sum())
    return np.asarray(candidates[np.append(np.arange(n_even), chosen)])


def search(file: Path, n_sets: int, seed: int) -> None:
    """Draw and measure sets until the file holds `n_sets`."""
    table = load(file)
    draws, episodes = sets_of(table)
    while len(draws) < n_sets:
        new = next_draws(draws, episodes, seed).astype(np.float32).astype(float)
        sets = [values_of(each) for each in new]
        measured = measure_all(sets, is_whole=len(draws) == 0)
        rows = [{"draw": draw.tolist(), **values, "episodes": [asdict(each) for each in of]}
                for draw, values, of in zip(new, sets, measured, strict=True)]  # fmt: skip
        tables = table, pa.Table.from_pylist(rows)
        table = pa.concat_tables(tables, promote_options="permissive")
        save(file, table)
        draws, episodes = np.concatenate([draws, new]), [*episodes, *measured]
        near = [sum(distance(each, arena) <= 1.0 for each in episodes) for arena in PUBLISHED]
        say(f"{len(draws)} sets, {near[0]} within the tolerances of es1, {near[1]} of es2")
