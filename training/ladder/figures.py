"""Figures of the ladder: the curves of a rung, and the performance profiles of all rungs."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from baselines.evaluation.figure_page import (
    NOTE,
    Caption,
    finish_figure,
    finish_panel,
    panel_grid,
    style_in_use,
)
from baselines.evaluation.line_plots import Means, draw_band
from baselines.evaluation.plot_style import FAINT, PALETTE, SeriesStyle, nth_style
from baselines.evaluation.statistics import performance_profile
from training.ladder.rungs import Rung, read_algorithms, title_of
from training.ladder.runs import Run, by_algorithm, iqm, score_word, strata_of

MILLION, MINUTE = 1e6, 60.0

Over = Literal["robot_steps", "wall_s"]

LONG = 20.0  # ratio of the longest to the shortest training that needs a logarithmic axis
CLOSE = 0.045  # least distance between the labels of lines, as a share of the panel's height
TAUS = np.linspace(0.0, 1.5, 61)  # normalised scores at which a profile is drawn


def curves(rung: Rung, runs: Sequence[Run], command: str) -> Figure:
    """Draw the score on a rung over robot-steps and wall-clock time, one line per algorithm."""
    groups = by_algorithm(runs)
    styles = _styles(groups)
    figure, panels = panel_grid(2, 3.0, 3.0)
    over: tuple[Over, Over] = ("robot_steps", "wall_s")
    for axes, name in zip(panels, over, strict=True):
        drawn = {title_of(algorithm): _curve(group, name) for algorithm, group in groups.items()}
        for title, means in drawn.items():
            draw_band(axes, title, means, styles[title])
        ends = [means.x[-1] for means in drawn.values()]
        if max(ends) > LONG * min(ends):
            axes.set_xscale("log")
            axes.xaxis.set_major_formatter("{x:g}")
        else:
            axes.set_xlim(left=0.0)
    word = score_word(rung)
    finish_panel(panels[0], rung.card.title, ("robot-steps of training [million]", word))
    finish_panel(panels[1], "", ("wall-clock time of training [min]", word))
    top = max(panel.get_ylim()[1] for panel in panels)
    highest = max((score.mean for score in rung.card.scores.values()), default=0.0)
    for axes in panels:
        axes.set_ylim(0.0, 1.05 * max(top, highest))
        _draw_references(axes, rung, is_named=axes is panels[-1])
    return finish_figure(figure, panels, _caption(rung, runs, command), styles)


def profiles(rungs: Sequence[Rung], runs: Sequence[Run], command: str) -> Figure:
    """Draw the share of runs above each normalised score, one line per algorithm."""
    groups = by_algorithm(runs)
    styles = _styles(groups)
    figure, (axes,) = panel_grid(1, 4.0, 3.4)
    for algorithm, own in groups.items():
        share, low, high = performance_profile(strata_of(rungs, own), TAUS.tolist())
        means = Means(TAUS, 100.0 * share, 100.0 * low, 100.0 * high)
        draw_band(axes, title_of(algorithm), means, styles[title_of(algorithm)])
    axes.set_xlim(TAUS[0], TAUS[-1])
    labels = "normalised score: 0 random, 1 oracle", "runs above it [%]"
    finish_panel(axes, "Performance profiles", labels)
    names = ", ".join(rung.name for rung in rungs)
    text = f"Runs of {names}, with 95 % stratified bootstrap bands."
    return finish_figure(figure, [axes], Caption(text, command=command), styles)


def _styles(algorithms: Mapping[str, Sequence[Run]]) -> dict[str, SeriesStyle]:
    """Return a style for each algorithm, the same on all figures, unless another algorithm has the
    style, or has its colour while others are free."""
    known, used, styles = list(read_algorithms()), set[int](), {}
    for name in algorithms:
        number, colours = known.index(name), {each % len(PALETTE) for each in used}
        while number in used or (number % len(PALETTE) in colours and len(colours) < len(PALETTE)):
            number += 1
        used.add(number)
        styles[title_of(name)] = nth_style(number)
    return styles


def _curve(runs: Sequence[Run], over: Over) -> Means:
    """Return the interquartile mean of the runs' scores at each evaluation that all runs have."""
    points = list(zip(*(run.curve for run in runs), strict=False))
    x = np.array([np.median([point[over] for point in each]) for each in points])
    scores = [[[float(np.mean(point["scores"])) for point in each]] for each in points]
    estimates = [iqm(each) for each in scores]
    low, high = np.array([each.ends for each in estimates]).T
    mean = np.array([each.value for each in estimates])
    return Means(x / (MILLION if over == "robot_steps" else MINUTE), mean, low, high)


def _draw_references(axes: Axes, rung: Rung, is_named: bool) -> None:
    """Draw a thin grey line for each score of the card, named at its right end if `is_named`."""
    top = axes.get_ylim()[1]
    scores = {name: score.mean for name, score in rung.scores.items()}
    at = -1.0
    for name, score in sorted(scores.items(), key=lambda each: each[1]):
        axes.axhline(score, color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        at = max(score / top, at + CLOSE)
        if is_named:
            size = style_in_use().points(NOTE)
            axes.annotate(
                name, (1.01, at), xycoords="axes fraction", fontsize=size, color=FAINT, va="center"
            )


def _caption(rung: Rung, runs: Sequence[Run], command: str) -> Caption:
    seeds = {len(own) for own in by_algorithm(runs).values()}
    n = f"{min(seeds)}" if len(seeds) == 1 else f"{min(seeds)} to {max(seeds)}"
    text = (
        f"Rung {rung.card.rung}, {rung.name}. Interquartile means over the seeds of training with"
        " 95 % bootstrap bands, on held-back episodes. Broken lines: means of the card."
    )
    return Caption(text, f"n = {n} seeds of training", command)
