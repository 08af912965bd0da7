"""Boids motion in foraging: round trips of each motion over each localisation.

Not in the papers: the experiment itself. Motions of BOIDS 3 and the subsumption of TR 5.1, over
the filters of BOIDS 2 and social odometry (TR 4), in the arenas of TR 6.1, with the parameters
that were calibrated for subsumption and social odometry.
"""

from itertools import product

from baselines.evaluation.statistics import mean_interval
from baselines.papers.claim_result import Claim
from baselines.papers.claim_types import Order
from baselines.papers.experiments import Experiment, Results, Source, round_trips, sample
from baselines.papers.figures import Boxes, PaperFigure
from baselines.papers.paper import PAPERS, Paper

ARENAS = ("es1", "es2", "es3")

MOTIONS = ("subsumption", "boids-goal", "boids-static", "boids-adaptive")

LOCALISATIONS = {
    "social_odometry": "social odometry",
    "covariance_intersection": "covariance intersection",
    "decentralised_ekf": "decentralised EKF",
    "dead_reckoning": "dead reckoning",
}

REPLICATIONS = 30
"""As in the TR."""

LEFT_OPEN = {
    "The filters among e-pucks": "baselines.estimators.foraging_variants",
    "Steering": "baselines.motion.boids_foraging",
    "The experiment": "baselines.papers.boids_foraging",
}
"""Whose docstring says what is chosen, by heading."""


def combination(arena: str, motion: str, localisation: str) -> Experiment:
    """The experiment of one motion over one localisation."""
    return Experiment(arena, f"{motion}:estimator={localisation}")


def claims() -> list[Claim]:
    """Claims on what each layer adds; they are questions, as no paper has an answer."""
    found: list[Claim] = []
    best_motion, best_filter = MOTIONS[0], next(iter(LOCALISATIONS))
    for arena in ARENAS:
        for motion in MOTIONS[1:]:
            pair = (
                combination(arena, best_motion, best_filter),
                combination(arena, motion, best_filter),
            )
            found.append(Order(f"{arena}: subsumption above {motion}, social odometry", (pair,)))
        for name, words in list(LOCALISATIONS.items())[1:]:
            pair = (
                combination(arena, best_motion, best_filter),
                combination(arena, best_motion, name),
            )
            found.append(Order(f"{arena}: social odometry above {words}, subsumption", (pair,)))
        pair = (
            combination(arena, "boids-adaptive", best_filter),
            combination(arena, "boids-static", best_filter),
        )
        found.append(Order(f"{arena}: adaptive above static boids, social odometry", (pair,)))
    return found


def figures() -> list[PaperFigure]:
    """The box plot of round trips of every combination."""
    panels: dict[str, dict[str, dict[str, Source]]] = {
        arena: {
            words.replace(" ", "\n"): {
                motion: combination(arena, motion, name) for motion in MOTIONS
            }
            for name, words in LOCALISATIONS.items()
        }
        for arena in ARENAS
    }
    caption = "Round trips, motion by localisation."
    return [Boxes("boids_foraging", caption, ("", "round trips"), panels)]


def table(results: Results) -> str:
    """Markdown table of mean round trips with 95 % intervals, the best of an arena bold."""
    heading = ["arena", "motion", *LOCALISATIONS.values()]
    lines = [heading, ["---"] * len(heading)]
    for arena in ARENAS:
        means = {
            (motion, name): mean_interval(
                sample(results, combination(arena, motion, name), round_trips)
            )
            for motion, name in product(MOTIONS, LOCALISATIONS)
        }
        best = max(means, key=lambda key: means[key].value if means[key] else 0.0)  # type: ignore[union-attr]
        for motion in MOTIONS:
            row = [arena, motion]
            for name in LOCALISATIONS:
                found = means[motion, name]
                assert found is not None
                span = (
                    "" if found.interval is None else " ({:.0f} to {:.0f})".format(*found.interval)
                )
                text = f"{found.value:.0f}{span}"
                row.append(f"**{text}**" if (motion, name) == best else text)
            lines.append(row)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


@PAPERS.register("boids-foraging")
def boids_foraging() -> Paper:
    """The experiment of motion by localisation in every arena, as a paper."""
    return Paper(
        "boids-foraging", "boids_foraging", tuple(claims()), tuple(figures()),
        REPLICATIONS, LEFT_OPEN, table,
    )  # fmt: skip
