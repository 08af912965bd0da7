"""Claims that hold with a set of open numbers, in the episodes of the search or in all arenas.

Not in the paper, and chosen here:
- a claim holds if each of its means, or ratios of means, lies where it says, without a test;
- a beta that was not measured has the results of the nearest one;
- a set is checked in worlds that the search did not use, 30 of es1 and real. In es3 the areas have
  the distance, of four, at which SGIKF comes nearest to the published round trips; in ANTS they
  have today's.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow as pa

from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.console import say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.runner import evaluate
from baselines.papers.claim_types import DecidableClaim
from baselines.papers.experiments import Experiment, Results
from baselines.papers.open_prior import Value, configuration, named, place_of, today, values_of
from baselines.papers.open_search import (
    OTHERS,
    Draws,
    Measured,
    distance,
    load,
    measure,
    numbers_of,
    probabilities,
    save,
    sets_of,
)
from baselines.papers.paper import find_paper
from swarm_forage_env.arrays import Array, Bool, Float64, Int64

ARENAS = "es1", "es2"  # arenas of the search
N_PRIOR = 100_000  # draws of the prior, to which the posteriors give weights

TOGETHER = 8  # sets measured in the other arenas before each save
WORLDS = {"es1": 4, "real": 4, "es2": 1, "es3": 1, "ants2008": 1}
"""Number of worlds in which the search measures the claims on each arena."""

CHECK_SEED, WORKERS = 9000, 2
CHECKED = {"es1": 30, "real": 30, "es2": 8, "es3": 4, "ants2008": 8}
"""Number of worlds in which a set is checked, by arena; their seeds begin at `CHECK_SEED`."""

DISTANCES = (1.8, 2.4, 3.0, 3.6)  # distances of the areas of es3 to try [m]


@cache
def claims_of(*arenas: str) -> tuple[DecidableClaim, ...]:
    """Return the decidable claims of TR and ANTS on some arenas."""
    papers = (find_paper(name) for name in ("social-odometry", "ants2008"))
    claims = (each for paper in papers for each in paper.claims if each.text.startswith(arenas))
    return tuple(each for each in claims if isinstance(each, DecidableClaim))


def measured_beta(controller: str) -> str:
    """Return the controller with the nearest measured beta.

    >>> measured_beta("ssgiff:beta=1e-05")
    'ssgiff:beta=0.0001'
    """
    name, is_swept, beta = controller.partition(":beta=")
    if not is_swept:
        return controller
    swept = (each for each in OTHERS if each.startswith(name))
    return min(swept, key=lambda each: abs(math.log(float(each.partition("=")[2]) / float(beta))))


def holds(claim: DecidableClaim, results: Results) -> bool:
    """Return whether each mean, or ratio of means, of a claim lies in its range."""
    effects = [(each, np.mean(each.values), np.mean(each.base)) for each in claim.effects(results)]
    return all(base > 0.0 and of.low <= ours / base <= of.high for of, ours, base in effects)


@cache
def experiments_on(arena: str) -> Mapping[Experiment, Experiment]:
    """Return each experiment of the claims on an arena, with the one measured instead."""
    wanted = dict.fromkeys(each for claim in claims_of(arena) for each in claim.experiments)
    return {each: replace(each, controller=measured_beta(each.controller)) for each in wanted}


Key = tuple[str, str, int]  # arena, controller, and robots of an experiment


@cache
def key_of(experiment: Experiment) -> Key:
    """Return the key by which the episodes of an experiment are found among those of a set."""
    n_robots = named(experiment, "kinematic").scenario.task.n_robots
    return experiment.scenario, experiment.controller, n_robots


def held(episodes: Sequence[Measured]) -> dict[str, bool]:
    """Return whether each claim holds in a set, by its text, on completely measured arenas."""
    by_key: dict[Key, list[Any]] = {}
    for each in episodes:
        by_key.setdefault((each.arena, each.controller, each.n_robots), []).append(each)
    judged: dict[str, bool] = {}
    for arena in CHECKED:
        keys = {each: key_of(measured) for each, measured in experiments_on(arena).items()}
        if by_key.keys() >= {*keys.values()}:
            results = {each: by_key[key] for each, key in keys.items()}
            judged |= {claim.text: holds(claim, results) for claim in claims_of(arena)}
    return judged


@dataclass(frozen=True)
class Sets:
    """Sets of a file with their judgements; the first set is today's."""

    draws: Draws  # points of the sets in the unit cube
    prior: Draws  # draws of the prior
    posterior: Float64[Array, "2 draws"]
    """Weights of the draws of the prior in the posteriors of es1, and of es1 and es2."""
    numbers: Mapping[str, Float64[Array, "sets numbers"]]  # our values of the published ones
    far: Mapping[str, Float64[Array, " sets"]]  # distances from the published ones
    best_betas: Mapping[str, Mapping[str, int]]
    """Number of sets in which SSGIFF makes most round trips at a beta, by arena."""
    held: Sequence[Mapping[str, bool]]
    """Whether each claim holds in each set, on completely measured arenas."""
    scores: Mapping[str, Int64[Array, " sets"]]
    """Number of claims that hold, by arena; -1 if it was not measured completely."""

    @property
    def near(self) -> Bool[Array, " sets"]:
        """Sets within the tolerances of es1, all of which were measured in es2."""
        return np.asarray(self.far["es1"] <= 1.0)

    def total(self, *arenas: str) -> Int64[Array, " sets"]:
        """Return how many claims on some arenas hold; -1 if one was not measured completely."""
        scores = np.array([self.scores[each] for each in arenas])
        return np.where(scores.min(axis=0) < 0, -1, scores.sum(axis=0))

    def best(self, *arenas: str) -> list[int]:
        """Return the sets measured in some arenas, most claims first; ties by distance to es2."""
        total = self.total(*arenas)
        order = np.lexsort((self.far["es2"], -total))
        return [int(k) for k in order if total[k] >= 0]

    def front(self, *arenas: str) -> list[int]:
        """Return the best set at each point of the Pareto front of scores, most claims first."""
        scores = np.array([self.scores[each] for each in arenas]).T
        front: list[int] = []
        for k in self.best(*arenas):
            if all((scores[k] > scores[other]).any() for other in front):
                front.append(k)
        return front


def sets_in(file: Path) -> Sets:
    """Read and judge the sets of a file."""
    draws, episodes = sets_of(load(file))
    prior = np.random.default_rng(0).random((N_PRIOR, draws.shape[1]))
    es1, es2 = (probabilities(prior, draws, episodes, arena) for arena in ARENAS)
    numbers = {a: np.array([numbers_of(each, a) for each in episodes]) for a in ARENAS}
    far = {a: np.array([distance(each, a) for each in episodes]) for a in ARENAS}
    judged = [held(each) for each in episodes]
    scores = {a: np.array([score(each, a) for each in judged]) for a in CHECKED}
    whole = {a: [episodes[k] for k in np.flatnonzero(scores[a] >= 0)] for a in ARENAS}
    betas = {a: Counter(best_beta(each, a) for each in whole[a]) for a in ARENAS}
    weights = np.array([es1, es1 * es2])
    return Sets(draws, prior, weights, numbers, far, betas, judged, scores)


def score(judged: Mapping[str, bool], arena: str) -> int:
    """Return how many claims on an arena hold; -1 if it was not measured completely."""
    results = [holds for text, holds in judged.items() if text.startswith(arena)]
    return sum(results) if results else -1


def best_beta(episodes: Sequence[Measured], arena: str) -> str:
    """Return the beta at which SSGIFF makes most round trips in a set."""
    trips: Counter[str] = Counter()
    for each in episodes:
        if each.arena == arena and each.controller.startswith("ssgiff"):
            trips[each.controller] += each.round_trips
    return max(trips, key=lambda each: trips[each]).partition("=")[2]


def with_distances(sets: Sequence[Mapping[str, Value]]) -> list[dict[str, Value]]:
    """Return sets with the distance in es3 where SGIKF is nearest to 2000 trips; ANTS as today."""
    own = {"ants2008.area_distance": today()["ants2008.area_distance"]}
    tried = [{**values, **own, "es3.area_distance": each} for values in sets for each in DISTANCES]
    measured = measure(tried, [Experiment("es3", "ssgikf")], range(7000, 7001))
    misses = [abs(episodes[0].round_trips - 2000) for episodes in measured]
    nearest = np.reshape(misses, (-1, len(DISTANCES))).argmin(axis=1)
    return [tried[len(DISTANCES) * k + int(at)] for k, at in enumerate(nearest)]


def measure_in_all_arenas(file: Path, n_sets: int) -> None:
    """Measure today's set and the best sets of the search in the other arenas, and save them."""
    table = load(file)
    rows, best = table.to_pylist(), [k for k in sets_in(file).best(*ARENAS) if k][:n_sets]
    missing = [k for k in (0, *best) if {e["arena"] for e in rows[k]["episodes"]} <= {*ARENAS}]
    for at in range(0, len(missing), TOGETHER):
        batch = missing[at : at + TOGETHER]
        sets = [values_of(rows[k]["draw"]) for k in batch]
        sets = [*sets[: batch[0] == 0], *with_distances(sets[batch[0] == 0 :])]
        for k, values in zip(batch, sets, strict=True):
            rows[k] |= {"draw": place_of(values), **values}
        for arena in (each for each in CHECKED if each not in ARENAS):
            experiments = {key_of(each): each for each in experiments_on(arena).values()}
            measured = measure(sets, [*experiments.values()], range(7000, 7000 + WORLDS[arena]))
            for k, episodes in zip(batch, measured, strict=True):
                rows[k]["episodes"] += [asdict(each) for each in episodes]
        save(file, pa.Table.from_pylist(rows, table.schema))
        say(f"{at + len(batch)} of {len(missing)} sets measured in all arenas")


def check(
    values: Mapping[str, Value] | None, arena: str, physics: str, out: Path
) -> dict[str, bool]:
    """Return whether each claim on an arena holds with the values of a set; None: today's."""
    n, played = CHECKED[arena], experiments_on(arena)
    different = list(dict.fromkeys(played.values()))
    configurations = [
        configuration(each, values, physics) if values else each.configuration(physics)
        for each in different
    ]
    seeds = range(CHECK_SEED, CHECK_SEED + n)
    episodes = evaluate(configurations, seeds, Dataset(out), JoblibBackend(WORKERS))
    by = {each: episodes[n * k : n * (k + 1)] for k, each in enumerate(different)}
    results = cast(Results, {each: by[measured] for each, measured in played.items()})
    return {claim.text: holds(claim, results) for claim in claims_of(arena)}
