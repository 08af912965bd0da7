"""Figures of a metric: box plots, and tables of its means by motion and localisation."""

import json
from collections.abc import Sequence

from matplotlib.figure import Figure

from baselines.evaluation.box_plots import BOXES, box_panels
from baselines.evaluation.dataset import LOGGER
from baselines.evaluation.dataset_reader import EpisodeGroup
from baselines.evaluation.figure_page import Caption
from baselines.evaluation.figures.base import (
    SELECTION,
    PlotOptions,
    by_setup,
    codes,
    counted,
    figure,
    sample,
)
from baselines.evaluation.heat_maps import table_panels
from baselines.evaluation.statistics import INTERVALS, Estimate, mean_interval
from swarm_forage_env.errors import ConfigError


@figure("boxplot", *SELECTION, "metric")
def draw_boxplot(options: PlotOptions) -> Figure:
    """Draw the score, or another metric: a box for each controller, a panel for each setup."""
    return boxplot(options.groups, options.shown_metric, options.command)


def boxplot(groups: Sequence[EpisodeGroup], metric: str, command: str) -> Figure:
    """Draw a box for each group, a panel for each setup; the command goes into the caption."""
    panels = {
        setup: {each.label(): {"": sample(each, metric)} for each in listed}
        for setup, listed in by_setup(groups).items()
    }
    axis = groups[0].kind.axis(metric)
    n = max(len(each.episodes) for each in groups)
    caption = Caption(f"{axis.capitalize()}. {BOXES}", counted(groups), command, codes(groups), n)
    return box_panels(panels, ("", axis), caption)


LOCALISATION = "estimator"  # the layer that a row of the table varies


@figure("table", *SELECTION, "metric")
def draw_table(options: PlotOptions) -> Figure:
    """Draw a table of means: a row for each motion, a column for each localisation."""
    named = [each for each in options.groups if LOCALISATION in json.loads(each.parameters)]
    varied = {each.label(LOCALISATION) for each in named}
    combined = [each for each in options.groups if each.label(LOCALISATION) in varied]
    if not combined:
        raise ConfigError(
            "no controller here names its localisation; evaluate some that do, as in"
            " swarm-forage evaluate es1 subsumption:estimator=dead_reckoning"
            " boids-goal:estimator=social_odometry"
        )
    if len(combined) < len(options.groups):
        left = {group.label() for group in options.groups if group not in combined}
        LOGGER.warning("left out, because they name no localisation: %s", ", ".join(sorted(left)))
    tables: dict[str, dict[str, dict[str, Estimate | None]]] = {}
    for group in combined:
        rows = tables.setdefault(group.setup(), {})
        localisation = str(group.numbers[LOCALISATION]).replace("_", " ")
        mean = mean_interval(sample(group, options.shown_metric))
        rows.setdefault(group.label(LOCALISATION), {})[localisation] = mean
    axis = combined[0].kind.axis(options.shown_metric)
    text = f"{axis.capitalize()}: means over {INTERVALS}, darker is more."
    names = "localisation", "motion"
    caption = options.caption(text, combined, metric=options.shown_metric)
    return table_panels(tables, names, caption)
