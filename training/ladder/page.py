"""Page of the ladder in Markdown, with cards, tables and figures; tables for a terminal."""

import statistics
import textwrap
from collections.abc import Iterable, Sequence
from importlib.resources import files
from string import Template

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.evaluation.console import count_noun
from baselines.evaluation.statistics import Estimate
from baselines.evaluation.tables import markdown
from baselines.papers.reproduction import format_duration
from training.ladder.rungs import DEFAULTS, RANDOM, Algorithm, Rung, Score, title_of
from training.ladder.runs import Run, by_algorithm, by_rung, improvements, iqm, over_all, score_word

PROFILE = "profile"  # name of the figure of all rungs

BAR = "ssgikf"  # hand-written controller that a default should beat

MILLION = 1e6

MISSING = "-"

COARSE = 1000.0  # values from here on are shown as integers
FINE = 5.0  # values below are shown with two decimals


def page(rungs: Sequence[Rung], runs: Sequence[Run], command: str) -> str:
    """Return the text of the page; its figures are in images/ladder beside it."""
    text = (files("training.ladder") / "page.md").read_text("utf-8")
    heads = ("rung", "name", "robots learn", "tested in", "random", "hand-written", "oracle")
    with_runs = {run.rung for run in runs}
    return Template(text).substitute(
        command=command,
        cards=markdown(heads, [_card(rung, rung.name in with_runs) for rung in rungs]),
        rungs="\n\n".join(_rung(rung, group) for rung, group in by_rung(rungs, runs)),
        together=_together(rungs, runs),
        defaults=_defaults(rungs, runs),
        made=_made(rungs, runs),
    )


def _card(rung: Rung, has_runs: bool) -> tuple[str, ...]:
    """Return the line of a rung in the table of cards, with a link to its results if it has any."""
    card, scenario = rung.card, rung.test_scenario
    return (
        str(card.rung),
        f"[`{rung.name}`](#{rung.name})" if has_runs else f"`{rung.name}`",
        str(rung.keywords["learn"]),
        f"{scenario.name}, {scenario.task.n_robots} robots",
        shown(card.scores.get(RANDOM)),
        best_shown(rung),
        f"`{card.oracle}` {shown(card.scores.get(card.oracle))}",
    )


def _rung(rung: Rung, runs: Sequence[Run]) -> str:
    card = rung.card
    parts = [f"### {rung.name}", f"**{card.title}.** {card.hard}"]
    lines = [_reference(rung, name, score) for name, score in rung.scores.items()]
    best_first = sorted(by_algorithm(runs).values(), key=lambda group: -_score_of(group).value)
    lines += [_learned(rung, group) for group in best_first]
    heads = (
        score_word(rung), "score", "normalised", "worst seed", "stochastic", "n", "robot-steps",
        "time of a training",
    )  # fmt: skip
    parts.append(markdown(heads, lines))
    parts.append(f"![Curves of {rung.name}](images/ladder/{rung.name}.png)")
    return "\n\n".join(parts)


def _reference(rung: Rung, name: str, score: Score) -> tuple[str, ...]:
    n = f"{score.episodes} episodes"
    label = name if name == RANDOM else f"`{name}`"
    return label, shown(score), f"{rung.normalised(score.mean):.2f}", "", "", n, "", ""


def _learned(rung: Rung, runs: Sequence[Run]) -> tuple[str, ...]:
    """Return the line of an algorithm: interquartile means over the mean scores of its runs."""
    score, stochastic = _score_of(runs), iqm([[run.score_by_chance for run in runs]])
    return (
        f"**{title_of(runs[0].algorithm)}**",
        _with_interval(score.value, score.interval),
        f"{rung.normalised(score.value):.2f}",
        _with_interval(min(run.score for run in runs), None),
        _with_interval(stochastic.value, stochastic.interval),
        count_noun(len(runs), "seed"),
        _millions(max(run.robot_steps for run in runs)),
        format_duration(statistics.median(run.train_s for run in runs)),
    )


def _score_of(runs: Sequence[Run]) -> Estimate:
    return iqm([[run.score for run in runs]])


def _together(rungs: Sequence[Rung], runs: Sequence[Run]) -> str:
    if not runs:
        return "There are no runs yet."
    heads = ("algorithm", "normalised score, interquartile mean", "rungs", "runs")
    lines = [
        (title_of(name), _with_interval(estimate.value, estimate.interval), str(n), str(estimate.n))
        for name, (estimate, n) in over_all(rungs, runs).items()
    ]
    words = "Algorithms that ran on different rungs are not comparable in this table."
    parts = [markdown(heads, lines), words, f"![Profiles](images/ladder/{PROFILE}.png)"]
    base = next(iter(over_all(rungs, runs)))
    better = improvements(rungs, runs, base)
    if better:
        words = f"probability that a run beats one of {title_of(base)} on the same rung"
        pairs = [
            (title_of(name), _with_interval(estimate.value, estimate.interval), str(n))
            for name, (estimate, n) in better.items()
        ]
        parts.append(markdown(("algorithm", words, "rungs"), pairs))
    return "\n\n".join(parts)


def tables(rungs: Sequence[Rung], algorithms: Sequence[Algorithm]) -> Group:
    """Return every rung with its difficulty and scores, then the algorithms, for a terminal."""
    parts: list[Text | Table] = []
    for rung in rungs:
        card = rung.card
        parts.append(Text(f"{card.rung} {rung.name}", style="bold").append(f"  {card.title}"))
        parts.append(Text(textwrap.fill(card.hard, 78)))
        listed = ", ".join(f"{name} {score.mean:.1f}" for name, score in rung.scores.items())
        parts += [Text(listed or "no scores yet: swarm-forage benchmark cards"), Text()]
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("algorithm", "", "trained by"):
        table.add_column(heading)
    for each in algorithms:
        table.add_row(each.name, each.title, each.trainer)
    return Group(*parts, table)


def defaults_lines(rung: Rung, runs: Sequence[Run]) -> list[tuple[str, ...]]:
    """Return the head of the table and one line per algorithm: the score of each seed, the median,
    the minimum, the number of seeds above the hand-written `ssgikf`, the median on held-back seeds
    after half of the robot-steps, and the scores under the engine `kinematic`."""
    bar = rung.card.scores[BAR].mean
    lines = []
    for algorithm, own in by_algorithm(runs).items():
        scores = [run.score for run in own]
        lines.append((
            title_of(algorithm),
            _means(run.scores for run in own),
            _means(run.scores_by_chance for run in own),
            f"{statistics.median(scores):.1f}",
            f"{min(scores):.1f}",
            f"{sum(score > bar for score in scores)} of {len(own)}",
            f"{statistics.median(map(_after_half, own)):.0f}",
            format_duration(statistics.median(run.train_s for run in own)),
            _means(run.scores_kinematic for run in own),
            _means(run.scores_kinematic_by_chance for run in own),
        ))  # fmt: skip
    heads = (
        "algorithm", "score of each seed", "stochastic", "median", "least",
        f"above {BAR}", "median after half", "time", "under kinematic", "the same, stochastic",
    )  # fmt: skip
    return [heads, *sorted(lines, key=lambda line: -float(line[3]))]


def _means(scores: Iterable[Sequence[float]]) -> str:
    """Return the mean score of each run that has one."""
    return " ".join(f"{statistics.fmean(each):.0f}" for each in scores if each) or MISSING


def _after_half(run: Run) -> float:
    """Return the mean score on held-back seeds, evaluated nearest to half of the robot-steps."""
    middle = min(run.curve, key=lambda point: abs(point["robot_steps"] - run.robot_steps / 2))
    return statistics.fmean(middle["scores"])


def defaults_table(rung: Rung, runs: Sequence[Run]) -> Table:
    """Return the lines of `defaults_lines` as a table for a terminal."""
    heads, *lines = defaults_lines(rung, runs)
    table = Table(*heads, box=None, padding=(0, 2, 0, 0))
    for line in lines:
        table.add_row(*line)
    return table


def _defaults(rungs: Sequence[Rung], runs: Sequence[Run]) -> str:
    own = [run for run in runs if run.rung == "es1" and run.algorithm in DEFAULTS]
    if not own:
        return "There are no runs yet."
    heads, *lines = defaults_lines(next(rung for rung in rungs if rung.name == "es1"), own)
    return markdown(heads, lines)


def _made(rungs: Sequence[Rung], runs: Sequence[Run]) -> str:
    """Return the number of runs, their training time and the versions of the packages."""
    if not runs:
        return "Nothing."
    seconds = sum(run.train_s for run in runs)
    lines = [
        f"- {title_of(name)}: "
        + "; ".join(
            f"`{rung.name}` {count_noun(len(own), 'seed')} of {_millions(own[0].robot_steps)}"
            " robot-steps"
            for rung, own in by_rung(rungs, each)
        )
        for name, each in by_algorithm(runs).items()
    ]
    versions = ", ".join(f"{name} {number}" for name, number in runs[0].versions.items())
    in_all = f"{count_noun(len(runs), 'run')}, {format_duration(seconds)} of training in all"
    head = f"{in_all}, with {versions}:"
    return "\n".join([head, "", *lines])


def best_shown(rung: Rung) -> str:
    """Return the best hand-written controller that has a score, with the score."""
    scores = {name: rung.scores[name] for name in rung.card.controllers if name in rung.scores}
    if not scores:
        return MISSING
    best = max(scores, key=lambda name: scores[name].mean)
    return f"`{best}` {shown(scores[best])}"


def shown(score: Score | None) -> str:
    """Return a score with its interval; a dash if there is none."""
    if score is None:
        return MISSING
    ends = None if score.low is None or score.high is None else (score.low, score.high)
    return _with_interval(score.mean, ends)


def _with_interval(value: float, ends: tuple[float, float] | None) -> str:
    form = ".0f" if abs(value) >= COARSE else ".1f" if abs(value) >= FINE else ".2f"
    return f"{value:{form}}" + (f" ({ends[0]:{form}} to {ends[1]:{form}})" if ends else "")


def _millions(number: int) -> str:
    return f"{number / MILLION:g} M"
