"""The command `plot`: draw a figure of existing datasets."""

from pathlib import Path
from typing import Annotated, Literal

from typer import Argument, Option

from baselines.evaluation.common_options import completion_of, path
from baselines.evaluation.console import say

FIGURE_NAMES = (
    "boxplot", "curve", "on-path", "recruitment", "table", "paths", "learning", "weights",
)  # fmt: skip
"""The kinds of figures, which are not loaded to complete their names."""


PageStyleName = Literal["screen", "paper"]
"""The page styles of figures."""


def plot(  # noqa: PLR0913 the options of a command
    kind: Annotated[
        str,
        Argument(
            metavar="KIND",
            help="What to draw: one of the above.",
            autocompletion=completion_of(FIGURE_NAMES),
        ),
    ],
    sources: Annotated[
        list[str],
        Argument(
            metavar="DATASET",
            help="Folders that evaluate or reproduce has written; cards for learning,"
            " controllers for weights.",
        ),
    ],
    out: Annotated[
        list[Path],
        Option(
            parser=path, metavar="FILE", help="A .png, .pdf or .svg file; several, if repeated."
        ),
    ],
    scenarios: Annotated[
        list[str] | None,
        Option("--scenario", metavar="NAME", help="Only this one; may be repeated."),
    ] = None,
    controllers: Annotated[
        list[str] | None,
        Option(
            "--controller",
            metavar="NAME",
            help="Only this one: ssgiff, or ssgiff:beta=0.01; may be repeated.",
        ),
    ] = None,
    metric: Annotated[
        str | None,
        Option(
            help="Of boxplot, curve and table: messages, on_path_share, ...",
            show_default="the score",
        ),
    ] = None,
    x: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="Of curve: beta, task.n_robots, ...",
            show_default="the one number that varies",
        ),
    ] = None,
    seed: Annotated[int | None, Option(min=0, help="Of paths.", show_default="the first")] = None,
    style: Annotated[
        PageStyleName, Option(help="As broad as a page, or as a column of a paper.")
    ] = "screen",
    caption: Annotated[
        bool, Option("--caption", help="Draw the caption, with command and code, below the panels.")
    ] = False,
) -> None:
    """Draw a figure of episodes that have been evaluated.

    **boxplot**: the score of each controller, or another --metric.

    **curve**: the same over a number of the controller or the scenario (beta, task.n_robots).

    **on-path**: share of the robots on the path over time.

    **recruitment**: share of the robots that have visited both areas, over time.

    **table**: motion by localisation.

    **paths**: a map of where the robots were, from what evaluate --trajectories has kept; where
    nothing was kept, one episode is run anew. Also without a dataset: plot paths es1 nc ssgikf.

    **learning**: learning curves of trained policies, from the cards (.json) beside them.

    **weights**: how far each of some controllers believes what it hears, over the own and the
    heard path: plot weights ssgikf ssgiff learned-weighting.

    A controller has the same colour in every figure. What the figure shows, the command and the
    code behind it stand in the metadata of the file and beside it, in FILE.json. Examples:
    swarm-forage plot boxplot runs/es1 --out trips.png,
    swarm-forage plot curve runs/es1 --style paper --out beta.pdf
    """
    import baselines.evaluation.figures  # noqa: F401 enters the kinds
    from baselines.evaluation.figure_page import check_plot, draw_caption, page_style, save_figure
    from baselines.evaluation.figures.base import FIGURES, PlotOptions, check_options

    kind_of_figure = FIGURES[kind]
    for file in out:
        check_plot(file, "--out")
    options = PlotOptions(
        kind, sources, tuple(scenarios or ()), tuple(controllers or ()), metric, x, seed,
        style, caption,
    )  # fmt: skip
    check_options(options)
    with page_style(options.style):
        figure = kind_of_figure.draw(options)
        if options.with_caption:
            draw_caption(figure)
        for file in out:
            save_figure(figure, file, options.command, f"swarm-forage plot {options.kind}")
            say(f"wrote {file}")
