"""Box plot of a metric: a box for each controller, a panel for each setup."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from baselines.evaluation.box_plots import BOXES, box_panels
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


@figure("boxplot", *SELECTION, "metric")
def draw(options: PlotOptions) -> Figure:
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
