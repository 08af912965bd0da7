"""Shares of the robots over time: on the path, and recruited."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from baselines.evaluation.curves import (
    BANDS,
    Curve,
    curve_panels,
    path_over_time,
    recruited_over_time,
)
from baselines.evaluation.episode import Episode
from baselines.evaluation.figures.base import (
    FIGURES,
    SELECTION,
    Wish,
    by_setup,
    counted,
    size_of,
)


@dataclass(frozen=True)
class OverTime:
    """A share of the robots over time: a curve for each controller, a panel for each setup."""

    words: str
    axis: str
    curve: Callable[[Sequence[Episode]], Curve]
    options = SELECTION

    def draw(self, wish: Wish) -> Figure:
        """A curve with its band for each controller, a panel for each setup."""
        panels = {
            setup: {each.label(): self.curve(each.episodes) for each in groups}
            for setup, groups in by_setup(wish.foraging).items()
        }
        text = f"{self.words} {size_of(wish.groups)}{BANDS} {counted(wish.groups)}"
        figure = curve_panels(panels, ("time [s]", self.axis), wish.caption(text))
        for axes in figure.axes:
            axes.set_ylim(0.0, 102.0)
        return figure


FIGURES.register("on-path")(
    OverTime(
        "Robots that know both areas.",
        "robots on the path [%]",
        path_over_time,
    )
)
FIGURES.register("recruitment")(
    OverTime("Robots that have visited both areas.", "robots recruited [%]", recruited_over_time)
)
