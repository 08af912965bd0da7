"""The boxplot of a number of each episode: a box for each controller, a panel for each setup."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from baselines.evaluation.figures.base import (
    FIGURES,
    SELECTION,
    Wish,
    by_setup,
    counted,
    sample,
    size_of,
)
from baselines.evaluation.groups import Group
from baselines.evaluation.panels import BOXES, box_panels


class Boxplot:
    """Scores, or another metric, of controllers."""

    options = SELECTION | {"metric"}

    def draw(self, wish: Wish) -> Figure:
        """A box for each controller, a panel for each setup."""
        return boxplot(wish.groups, wish.shown, wish.command)


FIGURES.register("boxplot")(Boxplot())


def boxplot(groups: Sequence[Group], metric: str, command: str) -> Figure:
    """A box for each group, a panel for each setup; the command stands below."""
    panels = {
        setup: {_lines(each.label()): {"": sample(each, metric)} for each in listed}
        for setup, listed in by_setup(groups).items()
    }
    axis = groups[0].kind.axis(metric)
    text = f"{axis.capitalize()}. {size_of(groups)}{BOXES} {counted(groups)} {command}"
    return box_panels(panels, ("", axis), text)


def _lines(label: str) -> str:
    """A controller's name and parameters in lines."""
    return label.replace(":", ":\n").replace(",", ",\n")
