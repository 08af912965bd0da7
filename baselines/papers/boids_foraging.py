"""Boids motion in foraging: round trips of each motion over each localisation.

Not in the papers: the experiment itself. Motions of BOIDS 3 and the subsumption of TR 5.1, over
the filters of BOIDS 2 and social odometry (TR 4), in the arenas of TR 6.1, with the parameters
that were calibrated for subsumption and social odometry.
"""

from itertools import product

from baselines.evaluation.statistics import mean_interval
from baselines.evaluation.tables import markdown
from baselines.papers.claim_types import Claim, Order
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

LEFT_OPEN = {
    "The filters among e-pucks": "baselines.estimators.localisation:Localisation",
    "Steering": "baselines.motion.boids_foraging",
    "The experiment": "baselines.papers.boids_foraging",
}
"""Whose docstring says what is chosen, by heading."""


def combination(arena: str, motion: str, localisation: str) -> Experiment:
    """The experiment of one motion over one localisation."""
    return Experiment(arena, f"{motion}:estimator={localisation}")


def claims() -> list[Claim]:
    """Claims on what each layer adds; they are questions, as no paper has an answer."""
    orders: list[Claim] = []
    best_filter = next(iter(LOCALISATIONS))
    for arena in ARENAS:
        of = {motion: combination(arena, motion, best_filter) for motion in MOTIONS}
        best = of[MOTIONS[0]]
        for motion in MOTIONS[1:]:
            text = f"{arena}: subsumption above {motion}, social odometry"
            orders.append(Order(text, ((best, of[motion]),)))
        for name, words in list(LOCALISATIONS.items())[1:]:
            text = f"{arena}: social odometry above {words}, subsumption"
            orders.append(Order(text, ((best, combination(arena, MOTIONS[0], name)),)))
        text = f"{arena}: adaptive above static boids, social odometry"
        orders.append(Order(text, ((of["boids-adaptive"], of["boids-static"]),)))
    return orders


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
    lines = []
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
                mean = means[motion, name]
                assert mean is not None
                span = " ({:.0f} to {:.0f})".format(*mean.interval) if mean.interval else ""
                text = f"{mean.value:.0f}{span}"
                row.append(f"**{text}**" if (motion, name) == best else text)
            lines.append(row)
    return markdown(["arena", "motion", *LOCALISATIONS.values()], lines)


@PAPERS.register("boids-foraging")
def boids_foraging() -> Paper:
    """The experiment of motion by localisation in every arena, as a paper."""
    made = tuple(claims()), tuple(figures())
    return Paper("boids-foraging", "boids_foraging", *made, 30, LEFT_OPEN, table)
