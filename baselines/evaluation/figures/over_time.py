"""Line plots over time: the share of the robots on the path, and of those recruited."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from baselines.evaluation.figures.base import FIGURES, SELECTION, PlotOptions, by_setup
from baselines.evaluation.line_plots import (
    BANDS,
    Curve,
    curve_panels,
    path_over_time,
    recruited_over_time,
)
from swarm_forage_env.foraging.episode import ForagingEpisode


@dataclass(frozen=True)
class ShareOverTime:
    """The figures `on-path` and `recruitment`: a share of the robots over time."""

    words: str
    axis: str
    curve: Callable[[Sequence[ForagingEpisode]], Curve]
    options = SELECTION

    def draw(self, options: PlotOptions) -> Figure:
        """Draw a curve with its band for each controller, a panel for each setup."""
        panels = {
            setup: {each.label(): self.curve(each.episodes) for each in groups}
            for setup, groups in by_setup(options.foraging_groups).items()
        }
        caption = options.caption(f"{self.words} {BANDS}", options.groups)
        figure = curve_panels(panels, ("time [s]", self.axis), caption)
        for axes in figure.axes:
            axes.set_ylim(0.0, 102.0)
        return figure


FIGURES.register("on-path")(
    ShareOverTime("Robots that know both areas.", "robots on the path [%]", path_over_time)
)
FIGURES.register("recruitment")(
    ShareOverTime(
        "Robots that have visited both areas.", "robots recruited [%]", recruited_over_time
    )
)
