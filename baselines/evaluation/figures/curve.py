"""Line plots: a metric over one setting, such as beta; shares of the robots over time."""

import json
from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.dataset import LOGGER
from baselines.evaluation.dataset_reader import EpisodeGroup
from baselines.evaluation.figures.base import SELECTION, PlotOptions, by_setup, figure, sample
from baselines.evaluation.line_plots import (
    BANDS,
    Means,
    curve_panels,
    mean_panels,
    path_over_time,
    recruited_over_time,
)
from baselines.evaluation.listing import units
from baselines.evaluation.statistics import INTERVALS, mean_interval
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.parameters import resolve

AXES = {"task.n_robots": "robots", "radio.max_range": "radio range"}
"""Axis names of settings; others are named by the last part of their dotted name."""


@figure("curve", *SELECTION, "metric", "x")
def draw_curve(options: PlotOptions) -> Figure:
    """Draw means over a setting x: a curve for each controller, a flat line for one without x."""
    if options.x:  # `beta` or `weighting.beta`
        known = dict(chain(*(_numeric(group).items() for group in options.groups)))
        x = resolve(options.x, known, "number behind these episodes")
    else:
        x = _varied(options.groups)
    having = [group for group in options.groups if x in group.numbers]
    panels = _panels(options, having, x)
    ends = [float(group.numbers[x]) for group in having]
    for group in options.groups:
        if group not in having and group.setup() in panels:
            mean, low, high = (np.full(2, value) for value in _mean(options, group))
            span = np.array([min(ends), max(ends)])
            panels[group.setup()][group.label()] = Means(span, mean, low, high, is_level=True)
    head = having[0]
    axes = _axis(x, head), head.kind.axis(options.shown_metric)
    text = f"Means with {INTERVALS}."
    caption = options.caption(text, options.groups, metric=options.shown_metric)
    return mean_panels(panels, axes, caption)


def _panels(
    options: PlotOptions, groups: Sequence[EpisodeGroup], x: str
) -> dict[str, dict[str, Means]]:
    """Return the curves of the setups in which x varies, warn of others; ConfigError if in none."""
    setups = _series(groups, x)
    short = [setup for setup, each in setups.items() if max(map(len, each.values())) < 2]
    if len(short) == len(setups):
        raise ConfigError(_too_few(x, groups))
    for setup in short:
        LOGGER.warning("left out, because %s does not vary there: %s", x, setup)
    return {
        setup: {label: _means(options, listed, x) for label, listed in each.items()}
        for setup, each in setups.items()
        if setup not in short
    }


def _varied(groups: Sequence[EpisodeGroup]) -> str:
    """Return the setting that varies while all else is equal; ConfigError unless one does."""
    candidates = {name for group in groups for name in _numeric(group)}
    vary = {name for name in candidates if len({group.numbers.get(name) for group in groups}) > 1}
    names = []
    for name in sorted(vary):
        series = _series([group for group in groups if name in group.numbers], name)
        if max(len(listed) for each in series.values() for listed in each.values()) > 1:
            names.append(name)
    if len(names) == 1:
        return names[0]
    if names:
        raise ConfigError(f"several parameters vary: choose one with --x {' or --x '.join(names)}")
    raise ConfigError(_too_few("number", groups))


def _too_few(x: str, groups: Sequence[EpisodeGroup]) -> str:
    held = ", ".join(dict.fromkeys(f"{each.scenario} {each.label()}" for each in groups))
    return (
        f"no {x} takes two values while all else is the same ({held}); evaluate two values, as"
        " in swarm-forage evaluate es1 ssgiff:beta=0.001 ssgiff:beta=0.01, or with --set"
        " task.n_robots=5 and --set task.n_robots=10 into one folder"
    )


def _numeric(group: EpisodeGroup) -> dict[str, float]:
    return {name: value for name, value in group.numbers.items() if type(value) in (int, float)}


def _series(groups: Sequence[EpisodeGroup], x: str) -> dict[str, dict[str, list[EpisodeGroup]]]:
    """Return groups that differ in x (and `name`) only, ordered by x, by setup and controller."""
    shared: dict[str, list[EpisodeGroup]] = {}
    for group in groups:
        rest = {name: value for name, value in group.numbers.items() if name not in (x, "name")}
        key = json.dumps([group.controller, group.physics, rest], sort_keys=True)
        shared.setdefault(key, []).append(group)
    series: dict[str, dict[str, list[EpisodeGroup]]] = {}
    for each in shared.values():
        ordered = sorted(each, key=lambda group: float(group.numbers[x]))
        setups = list(dict.fromkeys(group.setup(x) for group in ordered))
        title = setups[0] if len(setups) == 1 else f"{setups[0]} to {setups[-1]}"
        series.setdefault(title, {}).setdefault(ordered[0].label(x), []).extend(ordered)
    return series


def _means(options: PlotOptions, groups: Sequence[EpisodeGroup], x: str) -> Means:
    rows = [(float(group.numbers[x]), *_mean(options, group)) for group in groups]
    return Means(*np.array(rows).T)


def _mean(options: PlotOptions, group: EpisodeGroup) -> tuple[float, float, float]:
    """Return the mean and its interval: at the mean if nothing varies, all NaN without values."""
    estimate = mean_interval(sample(group, options.shown_metric))
    if estimate is None:
        return np.nan, np.nan, np.nan
    return estimate.value, *estimate.ends


def _axis(x: str, group: EpisodeGroup) -> str:
    """Return the axis label of a setting, with its unit if the controller still exists."""
    try:
        configuration = group.configuration()
        unit = (units(configuration.scenario) | units(configuration.controller)).get(x, "")
    except (ConfigError, UnknownNameError):
        unit = ""
    name = AXES.get(x) or " ".join(x.split(".")[1:] or [x]).replace("_", " ")
    return f"{name} [{unit}]" if unit else name


OVER_TIME: dict[str, tuple[str, str, Callable[[Sequence[ForagingEpisode]], Means]]] = {
    "on-path": ("Robots that know both areas.", "robots on the path [%]", path_over_time),
    "recruitment": (
        "Robots that have visited both areas.", "robots recruited [%]", recruited_over_time,
    ),
}  # fmt: skip
"""Caption, axis label and curve of each share of the robots over time."""


@figure("on-path", *SELECTION)
@figure("recruitment", *SELECTION)
def draw_share_over_time(options: PlotOptions) -> Figure:
    """Draw a curve with its band for each controller, a panel for each setup."""
    words, axis, curve = OVER_TIME[options.kind]
    panels = {
        setup: {each.label(): curve(each.episodes) for each in groups}
        for setup, groups in by_setup(options.foraging_groups).items()
    }
    caption = options.caption(f"{words} {BANDS}", options.groups)
    drawn = curve_panels(panels, ("time [s]", axis), caption)
    for axes in drawn.axes:
        axes.set_ylim(0.0, 102.0)
    return drawn
