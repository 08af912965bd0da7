"""Line plots in panels: means with bands over time, and means with intervals over a setting."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from scipy import stats

from baselines.evaluation.figure_page import (
    LETTER,
    LINE,
    TICK,
    Caption,
    finish_figure,
    finish_panel,
    panel_grid,
    panel_width,
    spans_decades,
    style_in_use,
)
from baselines.evaluation.plot_style import INK, MARKERS, SeriesStyle, styles_of
from baselines.evaluation.statistics import CONFIDENCE, FEW, middle
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.episode import ForagingEpisode

RESAMPLES = 1000  # bootstrap resamples of a band
BANDS = f"Means with 95 % bootstrap bands, of fewer than {FEW} episodes Student's."  # in captions
NUMBERED = 6  # up to this many values of x are numbered one by one


@dataclass(frozen=True)
class Means:
    """Means over x with the ends of their intervals; NaN where there is none."""

    x: Float64[Array, " points"]
    mean: Float64[Array, " points"]
    low: Float64[Array, " points"]
    high: Float64[Array, " points"]
    published: Float64[Array, " points"] | None = None
    """Means of a paper, drawn as crosses; NaN where there is none."""
    is_level: bool = False  # the mean is the same at every x: a flat line with a band


PANEL = 2.4  # minimum width of a panel [inch]


def curve_panels(
    panels: Mapping[str, Mapping[str, Means]],
    axes_names: tuple[str, str],
    caption: Caption,
    controllers: Mapping[str, str] | None = None,
) -> Figure:
    """Return a figure of means with bands, a panel per setup; `controllers` as in `styles_of`."""
    styles = line_styles(panels, controllers)
    figure, all_axes = panel_grid(len(panels), PANEL)
    for axes, (title, series) in zip(all_axes, panels.items(), strict=True):
        for name, means in series.items():
            draw_band(axes, name, means, styles[name])
        axes.set_xlim(left=0.0)
        finish_panel(axes, title, axes_names, lowest=_lowest(series))
    return finish_figure(figure, all_axes, caption, styles)


def mean_panels(
    panels: Mapping[str, Mapping[str, Means]],
    axes_names: tuple[str, str],
    caption: Caption,
    one_y: bool = False,
    controllers: Mapping[str, str] | None = None,
) -> Figure:
    """Return a figure of means with error bars, a panel for each setup; `one_y`: one y range."""
    styles = line_styles(panels, controllers)
    figure, all_axes = panel_grid(len(panels), PANEL)
    every = [means for panel in panels.values() for means in panel.values()]
    tops = np.concatenate([np.fmax(means.high, means.mean) for means in every])
    highest = np.max(tops[np.isfinite(tops)], initial=0.0) or 1.0  # nothing to draw: an empty axis
    every_x = np.concatenate([means.x for means in every])
    is_log = spans_decades(every_x)
    for axes, (title, series) in zip(all_axes, panels.items(), strict=True):
        axes.set_xscale("log" if is_log else "linear")
        for name, means in zip(series, _side_by_side(list(series.values()), is_log), strict=True):
            _draw_means(axes, name, means, styles[name])
        _number_axis(axes, every_x, is_log)
        finish_panel(axes, title, axes_names, lowest=_lowest(series))
        if one_y:
            axes.set_ylim(0.0, 1.05 * highest)
    return finish_figure(figure, all_axes, caption, styles)


def _lowest(series: Mapping[str, Means]) -> float:
    """Return the lowest mean of a panel, or zero if none is negative."""
    means = np.concatenate([each.mean for each in series.values()])
    return float(np.fmin.reduce(means, initial=0.0))


def _number_axis(axes: Axes, every_x: Float64[Array, " points"], is_log: bool) -> None:
    """Set the ticks of the x axis: at decades, or at the points if they are few and far apart."""
    places = np.unique(every_x)
    left = 0.0 if 0.0 <= places[0] <= np.ptp(places) else places[0]
    if is_log:
        axes.xaxis.set_major_locator(LogLocator(numticks=12))
        axes.xaxis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=12))
        axes.xaxis.set_minor_formatter(NullFormatter())
        return
    letters = max(len(f"{place:g}") for place in places) + 1
    label_width = LETTER * style_in_use().points(TICK) * letters / (panel_width(axes) - 0.6)
    if len(places) <= NUMBERED and np.all(np.diff(places) > label_width * (places[-1] - left)):
        axes.set_xticks(places)
    else:
        axes.xaxis.set_major_locator(MaxNLocator("auto", integer=not np.any(every_x % 1.0)))
    if left < places[0]:
        axes.set_xlim(left=left)


def _side_by_side(series: Sequence[Means], is_log: bool) -> list[Means]:
    """Shift points of several series at one x, by at most half the distance to the next x."""
    places = [np.log10(means.x) if is_log else means.x for means in series]
    curves = [place for means, place in zip(series, places, strict=True) if not means.is_level]
    every, n_at = np.unique(np.concatenate(curves or places), return_counts=True)
    n_curves = max(1, len(curves))
    widest = 0.5 * float(np.diff(every).min()) / n_curves if len(every) > 1 else 0.0
    each = min(0.012 * float(np.ptp(every)), widest)
    shifts = iter(each * (np.arange(n_curves) - (n_curves - 1) / 2.0))
    moved = []
    for means, place in zip(series, places, strict=True):
        at = place if means.is_level else place + next(shifts) * np.isin(place, every[n_at > 1])
        moved.append(replace(means, x=10.0**at if is_log else at))
    return moved


def line_styles(
    panels: Mapping[str, Mapping[str, object]], controllers: Mapping[str, str] | None = None
) -> dict[str, SeriesStyle]:
    """Return a style for each series, the same in all panels; ConfigError if there are too many."""
    names = list(dict.fromkeys(name for panel in panels.values() for name in panel))
    if len(names) > len(MARKERS):
        raise ConfigError(
            f"{len(names)} curves: at most {len(MARKERS)} can be distinguished; choose some with"
            " --controller or --scenario"
        )
    return styles_of(names, controllers)


def draw_band(axes: Axes, name: str, means: Means, style: SeriesStyle) -> None:
    """Draw a line of means with its band."""
    axes.fill_between(means.x, means.low, means.high, color=style.colour, alpha=0.2, linewidth=0.0)
    step = max(1, len(means.x) // 8)
    marked = MARKERS.index(style.marker) % step, step
    page = style_in_use()
    axes.plot(
        means.x, means.mean, color=style.colour, linestyle=style.dashes, label=name,
        linewidth=page.points(LINE), marker=style.marker, markersize=page.points(4.5),
        markevery=marked,
    )  # fmt: skip


def mean_curve(x: Float64[Array, " points"], y: Float64[Array, "episodes points"]) -> Means:
    """The mean over episodes at each x in its 95 % percentile bootstrap band; of few, Student's."""
    n_episodes, mean = len(y), y.mean(axis=0)
    if n_episodes < FEW:
        error = y.std(axis=0, ddof=1) / math.sqrt(n_episodes) if n_episodes > 1 else math.nan
        half = stats.t.ppf(0.5 + 0.5 * CONFIDENCE, n_episodes - 1) * error
        return Means(x, mean, mean - half, mean + half)
    draws = np.random.default_rng(0).integers(n_episodes, size=(RESAMPLES, n_episodes))
    weights = np.stack([np.bincount(draw, minlength=n_episodes) for draw in draws]) / n_episodes
    return Means(x, mean, *middle(weights @ y))


def path_over_time(episodes: Sequence[ForagingEpisode]) -> Means:
    """Return the share of the robots on the path [%] over time [s]."""
    shares = 100.0 * np.array([episode.on_path_over_time for episode in episodes])
    n_samples = shares.shape[1]
    return mean_curve(np.arange(1, n_samples + 1) / n_samples * episodes[0].duration_s, shares)


def recruited_over_time(episodes: Sequence[ForagingEpisode], points: int = 101) -> Means:
    """Return the share of the robots that had visited both areas [%] over time [s]."""
    times = np.linspace(0.0, episodes[0].duration_s, points)
    counts = [np.searchsorted(each.recruited_at_s, times, side="right") for each in episodes]
    return mean_curve(times, 100.0 * np.array(counts) / episodes[0].n_robots)


def _draw_means(axes: Axes, name: str, means: Means, style: SeriesStyle) -> None:
    if means.is_level:
        draw_band(axes, name, means, style)
        return
    reach = np.nan_to_num(np.stack([means.mean - means.low, means.high - means.mean]))
    page = style_in_use()
    axes.errorbar(
        means.x, means.mean, reach, color=style.colour, label=name, linestyle=style.dashes,
        marker=style.marker, markersize=page.points(4.5), linewidth=page.points(LINE),
        elinewidth=page.points(1.0), capsize=page.points(2.5),
    )  # fmt: skip
    if means.published is not None:
        axes.plot(means.x, means.published, "x", color=INK, markersize=6.0, zorder=5)
