"""Heat map of mean scores by motion and localisation, a panel for each setup."""

import json
import logging

from matplotlib.figure import Figure

from baselines.evaluation.dataset_reader import EpisodeGroup
from baselines.evaluation.figures.base import SELECTION, PlotOptions, by_setup, figure, sample
from baselines.evaluation.heat_maps import table_panels
from baselines.evaluation.statistics import Estimate, mean_interval
from swarm_forage_env.errors import ConfigError

LOGGER = logging.getLogger("swarm-forage")

LOCALISATION = "estimator"
"""The layer that a row of the table varies."""


@figure("table", *SELECTION, "metric")
def draw(options: PlotOptions) -> Figure:
    """Draw a row for each motion, a column for each localisation."""
    varied = {
        each.label(LOCALISATION)
        for each in options.groups
        if LOCALISATION in json.loads(each.parameters)
    }
    combined = [each for each in options.groups if each.label(LOCALISATION) in varied]
    if not combined:
        raise ConfigError(
            "no controller here names its localisation; evaluate some that do, as in"
            " swarm-forage evaluate es1 subsumption:estimator=dead_reckoning"
            " boids-goal:estimator=social_odometry"
        )
    if len(combined) < len(options.groups):
        left = {group.label() for group in options.groups if group not in combined}
        LOGGER.warning("left out, as they name no localisation: %s", ", ".join(sorted(left)))
    tables = {setup: _table(options, each) for setup, each in by_setup(combined).items()}
    axis = combined[0].kind.axis(options.shown_metric)
    text = f"{axis.capitalize()}: mean over its 95 % bootstrap interval (BCa), darker is more."
    names = "localisation", "motion"
    return table_panels(tables, names, options.caption(text, combined))


def _table(
    options: PlotOptions, groups: list[EpisodeGroup]
) -> dict[str, dict[str, Estimate | None]]:
    table: dict[str, dict[str, Estimate | None]] = {}
    for group in groups:
        motion = group.label(LOCALISATION)
        localisation = str(group.numbers[LOCALISATION]).replace("_", " ")
        table.setdefault(motion, {})[localisation] = mean_interval(
            sample(group, options.shown_metric)
        )
    return table
