"""Robustness: round trips of sound robots in swarms with faulty ones, for every weighting rule.

Not in the papers: the experiment itself, in es1 of the TR. And chosen here:
- the score is the round trips of the sound robots, for each of them;
- the engine is `kinematic`, and the seeds are the same for all;
- robots die, and go stale, after five minutes; all other faults last from the start;
- liars turn the place that they would report by half a turn about themselves, or conspire to report
  one false place; both report complete confidence (p = 0);
- a rule breaks at the smallest share of faulty robots at which its sound robots make fewer than
  half the round trips that they make without faults, with a Mann-Whitney p below 0.01;
- a rule harms at a share if its sound robots make fewer round trips than those of `nc`, which do
  not communicate, under the same faults, with a Mann-Whitney p below 0.01.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import ClassVar

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.figure_page import Caption
from baselines.evaluation.line_plots import Means, mean_panels
from baselines.evaluation.statistics import Comparison, compare, mean_interval
from baselines.evaluation.tables import markdown
from baselines.papers.claim_types import Order, above
from baselines.papers.experiments import Experiment, Results, sample
from baselines.papers.figures import PaperFigure
from baselines.papers.paper import Paper
from swarm_forage_env.foraging.episode import ForagingEpisode

SCENARIO = "es1"

RULES = {  # controllers by their names on the page; Fermi filters at their best beta in es1
    "nc": "nc",
    "ssgikf": "ssgikf",
    "dsgikf": "dsgikf",
    "ssgiff": "ssgiff:beta=0.001",
    "dsgiff": "dsgiff:beta=0.001",
    "sikf": "sikf",
    "covariance": "covariance",
    "ssgikf-sceptical": "ssgikf-sceptical",
    "learned-weighting": "learned-weighting",
    "learned-both": "learned-both",
    "learned-sceptical": "learned-sceptical",
    "oracle-weighting": "oracle-weighting",
}

ALONE = "nc"

DEFENCES = {"ssgikf-sceptical": "ssgikf", "learned-sceptical": "ssgikf-sceptical"}
"""Rules against liars, each with the rule that it is compared with."""

SHARES = (0.1, 0.2, 0.5)  # shares of faulty robots
SHOWN = 0.2  # share in the table of the page
LATER = 300  # time at which robots die or go stale [s]

FAULTS = {  # name of the share and other settings, by kind of fault
    "liars, each its own": ("faults.liar.share",),
    "liars, conspiring": ("faults.liar.share", "faults.liar.conspire=place"),
    "stale": ("faults.stale.share", f"faults.stale.at={LATER}"),
    "deaf": ("faults.deaf.share",),
    "mute": ("faults.mute.share",),
    "dead, still talking": ("faults.dead.share", f"faults.dead.at={LATER}"),
    "worn": ("faults.worn.share",),
    "blind": ("faults.blind.share",),
}

LIARS = tuple(FAULTS)[:2]
MESSAGES, BODIES = tuple(FAULTS)[:5], tuple(FAULTS)[5:]

LEFT_OPEN = {
    "The faults": "swarm_forage_env.epuck.faults",
    "The messages": "baselines.estimators.falsified_messages",
    "The defence: a second witness": "baselines.estimators.sceptical_odometry",
    "The defence: a validation gate": "baselines.weighting.validation_gate",
    "The learned defence": "baselines.estimators.reputation_odometry",
    "The experiment": "baselines.papers.robustness",
}


def sound_trips(episode: ForagingEpisode) -> float:
    """Metric: mean round trips of the sound robots."""
    if episode.sound_robots is None or episode.round_trips_sound is None:
        return episode.round_trips / episode.n_robots
    return episode.round_trips_sound / episode.sound_robots


def experiment(rule: str, fault: str, share: float) -> Experiment:
    """Return the experiment of a rule with a share of faulty robots."""
    if share == 0.0:
        return Experiment(SCENARIO, RULES[rule])
    name, *others = FAULTS[fault]
    return Experiment(SCENARIO, RULES[rule], (f"{name}={share:g}", *others))


def trips(results: Results, rule: str, fault: str, share: float) -> list[float]:
    """Return the score of a rule for each seed."""
    return sample(results, experiment(rule, fault, share), sound_trips)


def relative_score(results: Results, rule: str, fault: str, share: float) -> Comparison:
    """Compare the score of a rule with faulty robots to its score without."""
    return compare(trips(results, rule, fault, share), trips(results, rule, fault, 0.0))


def breaks(results: Results, rule: str, fault: str, share: float) -> bool:
    """Return whether less than half of the score is left."""
    half = [0.5 * each for each in trips(results, rule, fault, 0.0)]
    return above(compare(half, trips(results, rule, fault, share)))


def harms(results: Results, rule: str, fault: str, share: float) -> bool:
    """Return whether robots that do not communicate do better with the same faults."""
    ours = trips(results, rule, fault, share)
    return rule != ALONE and above(compare(trips(results, ALONE, fault, share), ours))


def breaking_share(results: Results, rule: str, fault: str) -> float | None:
    """Return the smallest share at which a rule breaks; None if it never does."""
    return next((share for share in SHARES if breaks(results, rule, fault, share)), None)


def claims() -> Iterator[Order]:
    """Yield questions that no paper answers for these rules, each an order of two experiments."""
    for rule, fault in product(RULES, LIARS):
        if rule != ALONE:
            pair = experiment(rule, fault, 0.0), experiment(rule, fault, SHARES[0])
            text = f"{rule}: without faults above one liar of ten ({fault})"
            yield Order(text, (pair,), sound_trips)
            yield above_at_shown(ALONE, rule, fault)
    for (rule, other), fault in product(DEFENCES.items(), LIARS):
        yield above_at_shown(rule, other, fault)


def above_at_shown(rule: str, other: str, fault: str) -> Order:
    """Return the claim that one rule is above another at the share shown."""
    pair = experiment(rule, fault, SHOWN), experiment(other, fault, SHOWN)
    return Order(f"{rule} above {other}: {100 * SHOWN:.0f} % {fault}", (pair,), sound_trips)


@dataclass(frozen=True)
class OverShare(PaperFigure):
    """Figure of the round trips of sound robots over the share of faulty ones."""

    faults: Sequence[str]
    reading: ClassVar[str] = "Means with 95 % bootstrap intervals."

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """The experiments whose episodes are used."""
        all_of = product(self.faults, RULES, (0.0, *SHARES))
        return tuple(experiment(rule, fault, share) for fault, rule, share in all_of)

    def _draw(self, results: Results, caption: Caption) -> Figure:
        panels = {
            fault: {RULES[rule]: self._means(results, rule, fault) for rule in RULES}
            for fault in self.faults
        }
        axes = "faulty robots [%]", "round trips of a sound robot"
        return mean_panels(panels, axes, caption, one_y=True)

    def _means(self, results: Results, rule: str, fault: str) -> Means:
        shares = (0.0, *SHARES)
        estimates = [mean_interval(trips(results, rule, fault, share)) for share in shares]
        ends = [(each.value, *each.ends) for each in estimates if each is not None]
        return Means(100.0 * np.array(shares), *np.array(ends).T)


ABOUT = "Round trips of a sound robot over the share of faulty ones in es1"
FIGURES = (
    OverShare("robustness_messages", f"{ABOUT}: what robots tell and hear.", MESSAGES),
    OverShare("robustness_bodies", f"{ABOUT}: how robots move and see.", BODIES),
)


def table(results: Results) -> str:
    """Return two tables: rules that break first by fault; score kept by rule at the share shown."""
    return "\n\n".join((_first_broken(results), _relative_scores(results)))


def _first_broken(results: Results) -> str:
    heads, lines = ("fault", "breaks first", "at", "and keeps there", "others that break"), []
    for fault in FAULTS:
        broken = {rule: breaking_share(results, rule, fault) for rule in RULES}
        order = sorted(
            (share, _ratio(relative_score(results, rule, fault, share)), rule)
            for rule, share in broken.items()
            if share is not None
        )
        if not order:
            lines.append([fault, "none", "", "", ""])
            continue
        (share, _, first), *rest = order
        others = ", ".join(f"{rule} ({100 * at:.0f} %)" for at, _, rule in rest) or "none"
        keeps = _percent(relative_score(results, first, fault, share))
        lines.append([fault, first, f"{100 * share:.0f} %", keeps, others])
    return markdown(heads, lines)


def _relative_scores(results: Results) -> str:
    lines = []
    for rule in RULES:
        base = mean_interval(trips(results, rule, LIARS[0], 0.0))
        assert base is not None
        low, high = base.ends
        row = [rule, f"{base.value:.1f} ({low:.1f} to {high:.1f})"]
        for fault in FAULTS:
            text = _percent(relative_score(results, rule, fault, SHOWN))
            text = f"**{text}**" if breaks(results, rule, fault, SHOWN) else text
            row.append(f"{text} †" if harms(results, rule, fault, SHOWN) else text)
        lines.append(row)
    return markdown(("rule", "trips without faults", *FAULTS), lines)


def _ratio(comparison: Comparison) -> float:
    return comparison.ratio.value if comparison.ratio is not None else 0.0


def _percent(comparison: Comparison) -> str:
    if comparison.ratio is None:
        return "-"
    low, high = comparison.ratio.ends
    return f"{100 * comparison.ratio.value:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


PAPER = Paper("robustness", tuple(claims()), FIGURES, 10, LEFT_OPEN, table)
"""Experiment of every weighting rule with every fault."""
