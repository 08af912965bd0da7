"""Command `reproduce`: every claim and figure of a paper, from episodes run for it."""

from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console
from typer import Argument, Option

from baselines.evaluation.commands import PageStyleName
from baselines.evaluation.common_options import (
    AddressOption,
    BackendOption,
    EverySettingsOption,
    FileOption,
    FirstSeedOption,
    PhysicsOption,
    ThreadsOption,
    WorkersOption,
    completion_of,
    find_backend,
)

QUICK_EPISODES = 6  # replications of each experiment: the least number that can show an order


PAPER_NAMES = (
    "social-odometry", "ants2008", "adaptive-boids", "boids-foraging", "robustness", "transfer",
)  # fmt: skip
"""Names of the papers, listed here so that completion need not load the papers."""


def reproduce(  # noqa: PLR0913 the options of a command
    paper: Annotated[
        str, Argument(help="Name of a paper or study.", autocompletion=completion_of(PAPER_NAMES))
    ],
    quick: Annotated[
        bool, Option("--quick", help=f"{QUICK_EPISODES} replications: less exact.")
    ] = False,
    episodes: Annotated[
        str | None,
        Option(
            metavar="<N|adaptive>",
            help="Replications of each experiment; adaptive: as many as decide each claim, up to"
            " 400.",
            show_default="as in the paper",
        ),
    ] = None,
    seed: FirstSeedOption = 0,
    workers: WorkersOption = 2,
    threads: ThreadsOption = 1,
    out: Annotated[
        Path | None,
        FileOption(
            help="Folder of dataset, figures, claims and page.",
            show_default="runs/reproduce-<paper>",
        ),
    ] = None,
    settings: EverySettingsOption = None,
    policies: Annotated[
        list[str] | None,
        Option(
            "--policy",
            metavar="CONTROLLER",
            help="Policy to compare, as sb3:model.zip; may be repeated. For transfer.",
            show_default="the bundled ones",
        ),
    ] = None,
    physics: PhysicsOption = None,
    page: Annotated[
        Path | None,
        FileOption(help="Write the page here, its figures beside it.", show_default="in --out"),
    ] = None,
    style: Annotated[
        PageStyleName,
        Option(help="screen: figures as wide as a page; paper: as wide as a column, also as PDF."),
    ] = "screen",
    form: Annotated[
        Literal["table", "json"], Option("--format", help="Format of the claims.")
    ] = "table",
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Check this implementation against the claims of a paper: a table, its figures, a page.

    **social-odometry**: the technical report of social odometry (Gutiérrez et al. 2009).

    **ants2008**: the first paper on social odometry (Gutiérrez et al. 2008).

    **adaptive-boids**: boids rules for localisation (Smith et al. 2021).

    **boids-foraging**: each motion over each estimator in foraging; not from a paper.

    **robustness**: every weighting rule with faulty robots and liars; not from a paper.

    **transfer**: every bundled policy, or those of --policy, in 49 worlds, most of them new to it;
    not from a paper.

    Prints the expected time before it starts. Finished blocks of episodes are written to --out;
    a stopped run repeats at most the unfinished blocks. With --episodes=adaptive the page is
    written after each look at the claims, undecided ones included. The exit status is 0 whether or
    not the claims hold, and 1 if stored episodes are missing at the end.
    """
    from baselines.evaluation.console import say
    from baselines.evaluation.runner import check_kept
    from baselines.papers import report
    from baselines.papers.reproduction import ADAPTIVE, ReproduceOptions, Reproduction

    adaptive = episodes == ADAPTIVE
    n = _number(episodes) if episodes and not adaptive else QUICK_EPISODES if quick else None
    spread = find_backend(backend, workers, threads, address)
    options = ReproduceOptions(paper, n, adaptive, seed, physics, settings or [], policies or [])
    run = Reproduction(options, out, page)
    run.run_with_progress(spread)
    run.write_figures(style)
    run.write()
    if adaptive:
        run.decide(spread)
    for file in run.files:
        say(str(file))
    if form == "json":
        typer.echo(report.to_json(run.claim_results))
    else:
        Console().print(report.claims_table(run.claim_results))
        if run.decided:
            Console().print(report.decided_table(run.decided))
    check_kept(run.plan)


def _number(episodes: str) -> int:
    try:
        return int(episodes)
    except ValueError:
        raise typer.BadParameter(
            f"{episodes!r} is neither a whole number nor adaptive", param_hint="--episodes"
        ) from None
