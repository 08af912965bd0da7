"""Boids in foraging: round trips and localisation error of each motion over each estimator.

Not in the papers: the experiment itself. Motions of BOIDS III, the subsumption of TR 5.1 and a
learned motion, over the filters of social odometry (TR 4), covariance intersection (BOIDS II.1) and
dead reckoning, in arenas of TR 6.1, with the parameters that were calibrated for subsumption over
social odometry. And chosen here:
- SGIFF has its best beta in these arenas, 0.001 per cm; covariance intersection and dead reckoning
  have the estimator's own gain;
- p keeps the unit of its filter: a path, or the standard deviation in the worst direction. Adaptive
  boids have no trust left at a p of 10 m, a path, or of 1.3 m, the deviation after a straight path
  of 10 m; the learned motion was trained with paths, and treats a deviation as a short path;
- the localisation error is that of known areas: a robot that has forgotten an area has no error for
  it;
- a pair is better or worse than `ssgikf`, which is subsumption over SGIKF, if its round trips lie
  above or below, and its error below or above, with a Mann-Whitney p below 0.01.
"""

import math
from collections.abc import Mapping, Sequence

from baselines.evaluation.statistics import Estimate, compare, mean_interval
from baselines.evaluation.tables import markdown
from baselines.papers.claim_types import Order, above, present_pairs
from baselines.papers.experiments import Experiment, Metric, Results, round_trips
from baselines.papers.figures import RatioMaps
from baselines.papers.paper import Paper
from swarm_forage_env.foraging.episode import ForagingEpisode

ARENAS = ("es1", "es2")

MOTIONS = ("subsumption", "boids-goal", "boids-static", "boids-adaptive", "learned-motion")

PATH, DEVIATION = 10.0, 1.3
"""p from which adaptive boids trust no estimate, as a path and as a standard deviation [m]."""

ESTIMATORS: Mapping[str, tuple[str, float]] = {
    "SGIKF": ("estimator=social_odometry,weighting=sgikf", PATH),
    "SGIFF": ("estimator=social_odometry,weighting=sgiff,beta=0.001", PATH),
    "covariance intersection": ("estimator=covariance_intersection,weighting=filter", DEVIATION),
    "dead reckoning": ("estimator=dead_reckoning,weighting=filter", DEVIATION),
}
"""Layers below the motion, and p from which adaptive boids trust no estimate, by estimator."""


def localisation_error(episode: ForagingEpisode) -> float:
    """Metric: mean error of the known areas [cm]; NaN if no robot ever knew one."""
    error = episode.localisation_error_m
    return math.nan if error is None else 100.0 * error


WORDS = {round_trips: "", localisation_error: ", localisation error"}


def pair(arena: str, motion: str, estimator: str) -> Experiment:
    """Return the experiment of one motion over one estimator."""
    layers, trust = ESTIMATORS[estimator]
    gains = f",trust={trust:g}" if motion == "boids-adaptive" else ""
    return Experiment(arena, f"{motion}:{layers}{gains}")


def base(arena: str) -> Experiment:
    """Return the experiment that all others are compared with: `ssgikf`."""
    return pair(arena, "subsumption", "SGIKF")


ACROSS_MOTIONS = [
    Order(
        f"{arena}{WORDS[metric]}: {more} above {less}, every motion",
        tuple((pair(arena, each, more), pair(arena, each, less)) for each in MOTIONS),
        metric,
    )
    for arena in ARENAS
    for more, less, metric in (
        ("SGIKF", "dead reckoning", round_trips),
        ("SGIKF", "covariance intersection", round_trips),
        ("SGIFF", "SGIKF", round_trips),
        ("dead reckoning", "covariance intersection", localisation_error),
    )
]
"""Orders of the estimators, each with every motion."""

ACROSS_ESTIMATORS = [
    Order(
        f"{arena}{WORDS[metric]}: {more} above {less}, every estimator",
        tuple((pair(arena, more, each), pair(arena, less, each)) for each in ESTIMATORS),
        metric,
    )
    for arena in ARENAS
    for more, less, metric in (
        ("subsumption", "boids-goal", round_trips),
        ("boids-goal", "boids-adaptive", round_trips),
        ("boids-adaptive", "boids-static", round_trips),
        ("learned-motion", "subsumption", round_trips),
        ("boids-goal", "boids-adaptive", localisation_error),
    )
]
"""Orders of the motions, each with every estimator."""


CAPTION = "Round trips of ssgikf, and of each motion over each estimator as a multiple of them."
RATIOS = {
    arena: {
        motion: {
            name.replace(" ", "\n"): (pair(arena, motion, name), base(arena)) for name in ESTIMATORS
        }
        for motion in MOTIONS
    }
    for arena in ARENAS
}
"""Each pair and its base, by arena, motion and estimator."""


def table(results: Results) -> str:
    """Return tables with 95 % intervals: round trips, localisation error, ratios of the orders."""
    return "\n\n".join((
        _means(results, "round trips", round_trips),
        _means(results, "error [cm]", localisation_error),
        _ratios(results, ACROSS_MOTIONS, MOTIONS),
        _ratios(results, ACROSS_ESTIMATORS, list(ESTIMATORS)),
    ))  # fmt: skip


def _means(results: Results, name: str, metric: Metric) -> str:
    lines = [
        [arena, motion, *(_mean(results, pair(arena, motion, each), metric) for each in ESTIMATORS)]
        for arena in ARENAS
        for motion in MOTIONS
    ]
    return markdown([name, "motion", *ESTIMATORS], lines)


def _mean(results: Results, experiment: Experiment, metric: Metric) -> str:
    """Return a mean, marked if it is better or worse than that of `ssgikf`."""
    ours, bases = present_pairs(results, experiment, base(experiment.scenario), metric)
    mean = mean_interval(ours)
    return _marked(mean, 0, ours, bases) if metric is round_trips else _marked(mean, 1, bases, ours)


def _ratios(results: Results, orders: Sequence[Order], columns: Sequence[str]) -> str:
    lines = []
    for order in orders:
        sides = (present_pairs(results, *each, order.metric) for each in order.pairs)
        title, _, _ = order.text.rpartition(", every ")
        ratios = ((compare(*each).ratio if each[0] else None, each) for each in sides)
        lines.append([title, *(_marked(ratio, 2, *each) for ratio, each in ratios)])
    return markdown(["ratio", *columns], lines)


def _marked(
    estimate: Estimate | None, digits: int, more: Sequence[float], less: Sequence[float]
) -> str:
    """Format an estimate with its interval; bold if `more` is above `less`, a dagger if below."""
    if estimate is None:
        return "-"
    value, low, high = (f"{each:.{digits}f}" for each in (estimate.value, *estimate.ends))
    text = f"{value} ({low} to {high})"
    if above(compare(more, less)):
        return f"**{text}**"
    return f"{text} †" if above(compare(less, more)) else text


LEFT_OPEN = {
    "The filters among e-pucks": "baselines.estimators.localisation:Localisation",
    "Steering": "baselines.motion.boids:steer_epuck",
    "The experiment": "baselines.papers.boids_foraging",
}

CLAIMS = (*ACROSS_MOTIONS, *ACROSS_ESTIMATORS)
FIGURES = (RatioMaps("boids_foraging", CAPTION, RATIOS),)

PAPER = Paper("boids-foraging", CLAIMS, FIGURES, 30, LEFT_OPEN, table)
"""Experiment of every motion over every estimator."""
