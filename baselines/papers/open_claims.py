"""Which claims hold in a set of open numbers: in the few episodes of the search, or in all arenas.

Not in the paper, and chosen here:
- a claim holds if each of its means, or ratios of means, lies where it says, without a test;
- for a beta that was not measured the nearest one speaks;
- a set is checked in other worlds than the search had, with the areas of es3 where SGIKF comes
  nearest to the published round trips, of four distances, and those of ANTS where today's are.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.runner import evaluate
from baselines.papers.claim_types import DecidableClaim
from baselines.papers.emulator import Draws
from baselines.papers.experiments import Results
from baselines.papers.open_prior import PRIOR, Value, configuration, today
from baselines.papers.open_search import (
    OTHERS,
    Measured,
    chance,
    distance,
    load,
    measure,
    numbers_of,
    sets_of,
)
from baselines.papers.paper import PAPERS
from swarm_forage_env.arrays import Array, Bool, Float64, Int64

ARENAS = "es1", "es2"  # of the search
N_PRIOR = 100_000  # draws of the prior that posteriors are weights of

CHECK_SEED, WORKERS = 6000, 2
CHECKED = {"es1": 4, "real": 4, "es2": 1, "es3": 1, "ants2008": 1}
"""Worlds that a set is checked in, by arena, from `CHECK_SEED`, by so many processes."""

DISTANCES = (1.8, 2.4, 3.0, 3.6)  # of the areas of es3 [m]


@cache
def claims_of(*arenas: str) -> tuple[DecidableClaim, ...]:
    """The claims of TR and ANTS on some arenas."""
    papers = (PAPERS[name]() for name in ("social-odometry", "ants2008"))
    claims = (each for paper in papers for each in paper.claims if each.text.startswith(arenas))
    return tuple(each for each in claims if isinstance(each, DecidableClaim))


def measured_beta(controller: str) -> str:
    """The controller with the nearest beta that is measured.

    >>> measured_beta("ssgiff:beta=1e-05")
    'ssgiff:beta=0.0001'
    """
    name, is_swept, beta = controller.partition(":beta=")
    if not is_swept:
        return controller
    return min(
        (each for each in OTHERS if each.startswith(name)),
        key=lambda each: abs(math.log(float(each.partition("=")[2]) / float(beta))),
    )


def holds(claim: DecidableClaim, results: Results) -> bool:
    """Whether each mean, or ratio of means, of a claim lies where it says."""
    effects = [(each, np.mean(each.values), np.mean(each.base)) for each in claim.effects(results)]
    return all(base > 0.0 and of.low <= ours / base <= of.high for of, ours, base in effects)


def held(episodes: Sequence[Measured], arenas: Sequence[str]) -> dict[str, bool]:
    """Whether each claim on these arenas holds in a set, by its words."""
    found: dict[tuple[str, str], list[Any]] = {}
    for each in episodes:
        found.setdefault((each.arena, each.controller), []).append(each)
    return {
        claim.text: holds(
            claim, {e: found[e.scenario, measured_beta(e.controller)] for e in claim.experiments}
        )
        for claim in (claims_of(*arenas) if arenas else ())
    }


@dataclass(frozen=True)
class Sets:
    """The sets of a file, judged; the first is today's."""

    draws: Draws  # where they lie in the unit cube
    prior: Draws  # draws of the prior
    posterior: Float64[Array, "2 draws"]
    """Their weights in the posterior of es1, and of es1 and es2."""
    numbers: Mapping[str, Float64[Array, "sets numbers"]]  # ours of the published numbers, by arena
    far: Mapping[str, Float64[Array, " sets"]]  # their distances from them
    best_betas: Mapping[str, Mapping[str, int]]
    """In how many sets SSGIFF makes most round trips at a beta."""
    held: Sequence[Mapping[str, bool]]
    """Whether each claim holds, of the arenas in which all controllers were measured."""
    scores: Int64[Array, "sets arenas"]  # how many claims hold; -1 where they were not all measured

    @property
    def near(self) -> Bool[Array, " sets"]:
        """Those within the tolerances of es1, all of which were measured in es2."""
        return np.asarray(self.far["es1"] <= 1.0)

    @property
    def front(self) -> list[int]:
        """The nearest set of each point of the Pareto front of the scores, most claims first."""
        nearest_last = np.argsort(-self.far["es2"], kind="stable")
        at = {tuple(self.scores[k]): int(k) for k in nearest_last if min(self.scores[k]) >= 0}
        kept = [a for a in at if not any(min(np.subtract(b, a)) >= 0 for b in at if b != a)]
        return [at[each] for each in sorted(kept, key=lambda each: (-sum(each), each))]

    @property
    def best(self) -> list[int]:
        """The sets but today's, those first in which most claims hold; of equals the nearest."""
        whole = [k for k, scores in enumerate(self.scores) if k and min(scores) >= 0]
        return sorted(whole, key=lambda k: (-int(self.scores[k].sum()), self.far["es2"][k]))


def sets_in(file: Path) -> Sets:
    """Judge the sets of a file."""
    draws, episodes = sets_of(load(file))
    prior = np.random.default_rng(0).random((N_PRIOR, len(PRIOR)))
    es1, es2 = (chance(prior, draws, episodes, arena) for arena in ARENAS)
    numbers = {a: np.array([numbers_of(each, a) for each in episodes]) for a in ARENAS}
    far = {a: np.array([distance(each, a) for each in episodes]) for a in ARENAS}
    done = [{e.arena for e in each if e.controller == OTHERS[0]} for each in episodes]
    judged = [held(each, sorted(arenas)) for each, arenas in zip(episodes, done, strict=True)]
    scores = [
        [sum(v for k, v in each.items() if k.startswith(a)) if a in arenas else -1 for a in ARENAS]
        for each, arenas in zip(judged, done, strict=True)
    ]
    pairs = [*zip(episodes, done, strict=True)]
    betas = {a: Counter(best_beta(each, a) for each, of in pairs if a in of) for a in ARENAS}
    weights = np.array([es1, es1 * es2])
    return Sets(draws, prior, weights, numbers, far, betas, judged, np.array(scores))


def best_beta(episodes: Sequence[Measured], arena: str) -> str:
    """The beta at which SSGIFF makes most round trips in a set."""
    trips: dict[str, int] = {}
    for each in episodes:
        if each.arena == arena and each.controller.startswith("ssgiff"):
            trips[each.controller] = trips.get(each.controller, 0) + each.round_trips
    return max(trips, key=lambda each: trips[each]).partition("=")[2]


def with_other_arenas(values: Mapping[str, Value]) -> dict[str, Value]:
    """A set with its areas of es3 where SGIKF is nearest to 2000 trips, of ANTS as today."""
    own = {**values, "ants2008.area_distance": today()["ants2008.area_distance"]}
    tried = [{**own, "es3.area_distance": each} for each in DISTANCES]
    trips = [
        episodes[0].round_trips
        for episodes in measure(tried, "es3", ("ssgikf",), range(7000, 7001))
    ]
    return tried[int(np.argmin(np.abs(np.subtract(trips, 2000))))]


def check(
    values: Mapping[str, Value] | None, arena: str, physics: str, out: Path
) -> dict[str, bool]:
    """Whether each claim on an arena holds with the numbers of a set; None: with today's."""
    claims, n = claims_of(arena), CHECKED[arena]
    wanted = dict.fromkeys(each for claim in claims for each in claim.experiments)
    played = {e: replace(e, controller=measured_beta(e.controller)) for e in wanted}
    different = list(dict.fromkeys(played.values()))
    configurations = [
        configuration(each, values, physics) if values else each.configuration(physics)
        for each in different
    ]
    seeds = range(CHECK_SEED, CHECK_SEED + n)
    episodes = evaluate(configurations, seeds, Dataset(out), JoblibBackend(WORKERS))
    by = {each: episodes[n * k : n * (k + 1)] for k, each in enumerate(different)}
    results = cast(Results, {each: by[played[each]] for each in wanted})
    return {claim.text: holds(claim, results) for claim in claims}
