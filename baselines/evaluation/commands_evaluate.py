"""The command `evaluate`: run controllers on a scenario, and compare them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich.console import Console
from typer import Argument, Option

from baselines.evaluation.common_options import (
    AddressOption,
    BackendOption,
    FirstSeedOption,
    PhysicsOption,
    ScenarioArgument,
    SettingsOption,
    ThreadsOption,
    WorkersOption,
    controller_names,
    find_backend,
    path,
)
from baselines.evaluation.console import say

if TYPE_CHECKING:
    from baselines.evaluation.runner import Plan


def evaluate(  # noqa: PLR0913 the options of a command
    scenario: ScenarioArgument,
    controllers: Annotated[
        list[str],
        Argument(
            help="Names, with parameters if need be: ssgiff:beta=0.02,refractory=10; or layers:"
            " social_odometry+sgiff+subsumption",
            autocompletion=controller_names,
        ),
    ],
    episodes: Annotated[int, Option(help="Episodes for each controller.")] = 30,
    seed: FirstSeedOption = 0,
    workers: WorkersOption = 2,
    threads: ThreadsOption = 1,
    out: Annotated[
        str | None,
        Option(
            metavar="PATH",
            help="Folder of the dataset (Parquet), or an address: s3://bucket/x.",
            show_default="runs/<scenario>",
        ),
    ] = None,
    settings: SettingsOption = None,
    physics: PhysicsOption = None,
    form: Annotated[
        Literal["table", "json", "csv"], Option("--format", help="How to write the result.")
    ] = "table",
    series: Annotated[
        bool, Option("--series", help="In JSON, tell what is known over time as well.")
    ] = False,
    trajectories: Annotated[
        bool,
        Option(
            "--trajectories",
            help="Keep where every robot was in every tick, in the folder OUT-trajectories.",
        ),
    ] = False,
    plot: Annotated[
        Path | None, Option(parser=path, help="Draw the scores to a .png, .pdf or .svg file.")
    ] = None,
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Run controllers on a scenario and compare them: by round trips, or goals reached.

    All controllers meet the same seeds. Episodes run in blocks, side by side, and a block is
    kept in the folder --out as soon as it has ended: the bar counts the episodes kept. The same
    command later runs only what is missing, so that a run that was stopped repeats at most the
    blocks that it was amid, one for each worker.
    """
    from baselines.evaluation.evaluate_options import EvaluateOptions
    from baselines.evaluation.runner import check_kept, run_with_progress

    request = EvaluateOptions(scenario, controllers, episodes, seed, settings or [], physics)
    spread = find_backend(backend, workers, threads, address)
    if plot:
        _check_plot(plot, out)
    plan = request.plan(out, trajectories)
    run_with_progress(plan, spread)
    results = plan.results()
    if plot:
        _draw(plan, plot, request.command)
    _write(results, form, series)
    check_kept(plan)


def _check_plot(file: Path, out: str | None) -> None:
    from baselines.evaluation.figure_page import check_plot

    check_plot(file)
    if out and Path(out).resolve() in file.resolve().parents:
        say(f"--plot lies inside --out: read the dataset as {out}/scenario=*/**/*.parquet")


def _draw(plan: "Plan", file: Path, command: str) -> None:
    from baselines.evaluation.dataset_reader import EpisodeGroup
    from baselines.evaluation.figure_page import save_figure
    from baselines.evaluation.figures.boxplot import boxplot

    groups = list(map(EpisodeGroup.of, plan.configurations, plan.by_configuration()))
    save_figure(boxplot(groups, groups[0].kind.score, command), file, command)
    say(f"wrote {file}")


def _write(results: Sequence[Any], form: str, series: bool) -> None:
    from baselines.evaluation import tables

    if form == "table":
        Console().print(tables.report(results))
    elif form == "json":
        typer.echo(tables.to_json(results, series))
    else:
        typer.echo(tables.to_csv(results))
