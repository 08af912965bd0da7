"""The commands of `swarm-forage`. Results go to stdout, messages to stderr."""

import json
import logging
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from baselines.evaluation.commands_plot import plot as plot_figure
from baselines.evaluation.commands_watch import watch
from baselines.evaluation.console import old_names_told, say
from baselines.papers.commands_reproduce import reproduce
from swarm_forage_env.errors import ConfigError, UnknownNameError

if TYPE_CHECKING:
    from baselines.evaluation.runner import Plan

app = typer.Typer(
    name="swarm-forage",
    help="Multi-robot foraging: hand-written controllers, evaluated and compared.",
    epilog="Start with: swarm-forage evaluate es1 nc ssgikf ssgiff",
    rich_markup_mode="markdown",
    add_completion=False,
    pretty_exceptions_enable=False,
)


class Format(StrEnum):
    """Output formats of `evaluate`: table, JSON or CSV."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"


class ListFormat(StrEnum):
    """Output formats of `list` and `bench`: table or JSON."""

    TABLE = "table"
    JSON = "json"


ListedFormat = Annotated[ListFormat, typer.Option("--format", help="How to write the result.")]


class _ToStderr(logging.Handler):
    """Each message is a line on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line."""
        say(record.getMessage())


def run(arguments: Sequence[str] | None = None, commands: typer.Typer = app) -> int:
    """Run one command and return its exit status; an error becomes one line on stderr."""
    logger = logging.getLogger("swarm-forage")
    if not logger.handlers:
        logger.addHandler(_ToStderr())
    program = commands.info.name
    try:
        with old_names_told():
            status = commands(arguments, prog_name=program, standalone_mode=False)
        sys.stdout.flush()
    except (ConfigError, UnknownNameError) as error:
        return _refuse(str(error), 2)
    except BrokenPipeError:  # the reader of our output has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except BrokenExecutor:
        return _refuse("a worker was ended from outside; the same command goes on from here", 1)
    except OSError as error:
        return _refuse(str(error), 1)
    except Exception as error:
        if not hasattr(error, "format_message"):  # the parser's complaints have one
            raise
        complaint = error.format_message().replace("Value error, ", "")  # a word of pydantic's
        context = getattr(error, "ctx", None)
        command = context.command_path if context else program
        return _refuse(f"{complaint.rstrip('.')}. See: {command} --help", 2)
    return status if isinstance(status, int) else 0


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    show_version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.")
    ] = False,
) -> None:
    """Multi-robot foraging: hand-written controllers, evaluated and compared."""
    if show_version:
        try:
            typer.echo(version("swarm-forage"))
        except PackageNotFoundError:
            typer.echo("not installed")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command("list")
def list_names(
    name: Annotated[
        str | None,
        typer.Argument(help="A scenario, a .toml file or a controller: shows all its numbers."),
    ] = None,
    form: ListedFormat = ListFormat.TABLE,
) -> None:
    """Show the scenarios, controllers and engines there are, or every number of one of them."""
    from baselines.evaluation import listing

    if form is ListFormat.JSON:
        found = listing.describe(name) if name else listing.overview()
        typer.echo(json.dumps(found, indent=1))
    else:
        table = listing.detail_table(name) if name else listing.overview_tables()
        Console().print(table)


@app.command()
def evaluate(  # noqa: PLR0913 the options of a command
    scenario: Annotated[
        str, typer.Argument(help="A name (see `swarm-forage list`) or a .toml file.")
    ],
    controllers: Annotated[
        list[str],
        typer.Argument(
            help="Names, with parameters if need be: ssgiff:beta=0.02,refractory=10; or layers:"
            " social_odometry+sgiff+subsumption"
        ),
    ],
    episodes: Annotated[int, typer.Option(help="Episodes for each controller.")] = 30,
    seed: Annotated[int, typer.Option(help="Seed of the first; the others count up from it.")] = 0,
    workers: Annotated[int, typer.Option(help="Processes to run them in.")] = 2,
    threads: Annotated[
        int, typer.Option(help="Threads that the worlds of a process are spread over.")
    ] = 1,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the dataset (Parquet).", show_default="runs/<scenario>"),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Change a number of the scenario."),
    ] = None,
    physics: Annotated[
        str | None,
        typer.Option(
            help="Engine: rigid or kinematic.", show_default="rigid; kinematic for waypoints"
        ),
    ] = None,
    form: Annotated[
        Format, typer.Option("--format", help="How to write the result.")
    ] = Format.TABLE,
    series: Annotated[
        bool, typer.Option("--series", help="In JSON, tell what is known over time as well.")
    ] = False,
    trajectories: Annotated[
        bool,
        typer.Option(
            "--trajectories",
            help="Keep where every robot was in every tick, in the folder <out>-trajectories.",
        ),
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the scores to a .png, .pdf or .svg file.")
    ] = None,
) -> None:
    """Run controllers on a scenario and compare them: by round trips, or goals reached.

    All controllers meet the same seeds. Every episode is kept in the folder --out as soon as
    it has been run; the same command later uses what is there and runs only what is missing,
    so that a run that was stopped goes on where it was.
    """
    with stoppable():
        from baselines.evaluation.evaluate_options import EvaluateOptions, check_count
        from baselines.evaluation.progress import check_kept, run_with_progress

        request = EvaluateOptions(scenario, controllers, episodes, seed, settings or [], physics)
        check_count("--workers", workers)
        check_count("--threads", threads)
        if plot:
            _check_plot(plot, out)
        plan = request.plan(out, trajectories)
        run_with_progress(plan, workers, threads)
        results = plan.results()
        if plot:
            _draw(plan, plot, request.command)
        _write(results, form, series)
        check_kept(plan)


@app.command()
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="A short run, less exact.")] = False,
    threads: Annotated[int, typer.Option(help="Threads whose gain over one is measured.")] = 2,
    form: ListedFormat = ListFormat.TABLE,
) -> None:
    """Measure speed and memory against the budgets; takes a few minutes."""
    with stoppable(keeps=False):
        from baselines.evaluation.bench.measures import measure
        from baselines.evaluation.bench.tables import report

        console = Console(stderr=True)
        with console.status("") as status:
            tell = status.update if console.is_terminal else lambda _: None
            found = measure(quick, threads, tell)
        if form is ListFormat.JSON:
            typer.echo(json.dumps(found, indent=1))
        else:
            Console().print(report(found))


def _check_plot(file: Path, out: Path | None) -> None:
    from baselines.evaluation.plot_style import check_plot

    check_plot(file)
    if out and out.resolve() in file.resolve().parents:
        say(f"--plot lies inside --out: read the dataset as {out}/scenario=*/**/*.parquet")


def _draw(plan: "Plan", file: Path, command: str) -> None:
    from baselines.evaluation.dataset_reader import EpisodeGroup
    from baselines.evaluation.figures.boxplot import boxplot
    from baselines.evaluation.plot_style import save_figure

    episodes, n_seeds = plan.results(), len(plan.seeds)
    groups = [
        EpisodeGroup.of(configuration, episodes[number * n_seeds : (number + 1) * n_seeds])
        for number, configuration in enumerate(plan.configurations)
    ]
    save_figure(boxplot(groups, groups[0].kind.score, command), file, command)


def _write(results: Sequence[Any], form: Format, series: bool) -> None:
    from baselines.evaluation import tables

    if form is Format.TABLE:
        Console().print(tables.report(results))
    elif form is Format.JSON:
        typer.echo(tables.to_json(results, series))
    else:
        typer.echo(tables.to_csv(results))


@contextmanager
def stoppable(keeps: bool = True) -> Iterator[None]:
    """End a command on Ctrl-C or SIGTERM with exit status 130 and one line on stderr.

    Either way its workers end with it; `keeps` is whether what it has done is kept.
    """
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    except KeyboardInterrupt:
        say("stopped; the same command goes on from here" if keeps else "stopped")
        raise typer.Exit(130) from None
    finally:
        signal.signal(signal.SIGTERM, before)


def _refuse(complaint: str, status: int) -> int:
    say(" ".join(complaint.split()))
    return status


app.command("plot")(stoppable(keeps=False)(plot_figure))
app.command()(stoppable()(reproduce))
app.command()(stoppable(keeps=False)(watch))
