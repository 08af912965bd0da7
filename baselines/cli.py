"""Commands of `swarm-forage`. Results are written to stdout, messages to stderr."""

import json
import logging
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from typing import Annotated, Literal

import typer
from rich.console import Console
from typer import Argument, Context, Option
from typer.core import TyperArgument, TyperOption

from baselines.evaluation.commands import evaluate, play, watch
from baselines.evaluation.commands import plot as plot_figure
from baselines.evaluation.common_options import controller_names, scenario_names
from baselines.evaluation.console import error_message, interrupts_raised, report_old_names, say
from baselines.export.command import export
from baselines.new.command import new
from baselines.papers.commands_reproduce import reproduce
from swarm_forage_env.registry import left_out

app = typer.Typer(
    name="swarm-forage",
    help="Multi-robot foraging: evaluate, compare, train and watch controllers.",
    epilog="Start with: swarm-forage evaluate es1 nc ssgikf ssgiff",
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)


ListedFormat = Annotated[Literal["table", "json"], Option("--format", help="Format of the result.")]


class _ToStderr(logging.Handler):
    """Logging handler that writes each message as a line to stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write the message of a record as one line."""
        say(record.getMessage())


VALUES = {"int": "N", "int range": "N", "float": "X", "str": "NAME", "Path": "PATH", "bool": ""}
"""Placeholders of values in help texts, by type; a switch has none."""


def value_in_help(parameter: TyperArgument | TyperOption, ctx: Context) -> str:
    """Return the choices or the placeholder that help shows for an argument or option."""
    is_option = isinstance(parameter, TyperOption)
    if is_option and parameter.metavar is not None:
        return parameter.metavar
    metavar = parameter.display_type(ctx)
    kind = metavar.strip("<>").removeprefix("list[").removesuffix("]")
    if kind not in VALUES:
        return metavar
    return VALUES[kind] if is_option else ""


def run(arguments: Sequence[str] | None = None, commands: typer.Typer = app) -> int:
    """Run one command and return its exit status; an error becomes one line on stderr."""
    logger = logging.getLogger("swarm-forage")
    if not logger.handlers:
        logger.addHandler(_ToStderr())
    for kind in (TyperArgument, TyperOption):
        kind.display_type_rich = value_in_help  # type: ignore[method-assign,assignment]
    program = commands.info.name
    try:
        with report_old_names():
            status = commands(arguments, prog_name=program, standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has closed the pipe
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as error:
        message = error_message(error, program)
        if message is None:
            raise
        line, status = message
        say(" ".join(line.split()))
    return status if isinstance(status, int) else 0


@contextmanager
def stoppable(keeps: bool = True) -> Iterator[None]:
    """End a command on Ctrl-C, SIGTERM or SIGHUP with exit status 130 and one line on stderr.

    Its workers end, too. `keeps`: the command has saved its progress and can be resumed.
    """
    try:
        with interrupts_raised():
            yield
    except KeyboardInterrupt:
        say("stopped; the same command resumes from here" if keeps else "stopped")
        raise typer.Exit(130) from None


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    show_version: Annotated[bool, Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Multi-robot foraging: hand-written controllers, evaluated and compared."""
    if show_version:
        typer.echo(version("swarm-forage"))
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command("list")
def list_names(
    name: Annotated[
        str | None,
        Argument(
            help="Scenario, .toml file, controller or layer whose parameters to show.",
            autocompletion=lambda incomplete: (
                scenario_names(incomplete) + controller_names(incomplete)
            ),
        ),
    ] = None,
    form: ListedFormat = "table",
) -> None:
    """Show scenarios, controllers, layers and engines, or all parameters of one (not an engine)."""
    from baselines.evaluation import listing

    if form == "json":
        typer.echo(json.dumps(listing.describe(name) if name else listing.overview(), indent=1))
    else:
        Console().print(listing.detail_table(name) if name else listing.overview_tables())
    if message := left_out():
        say(message)


app.command(
    epilog="Example: swarm-forage evaluate es1 nc ssgikf --episodes 30 --plot trips.png",
)(stoppable()(evaluate))


@app.command()
def bench(
    quick: Annotated[bool, Option("--quick", help="A shorter, less exact run.")] = False,
    threads: Annotated[
        int, Option(min=1, help="Number of threads whose speed-up is measured.")
    ] = 2,
    device: Annotated[
        Literal["cpu", "cuda"], Option(help="Device of the worlds: cpu, or cuda for a GPU.")
    ] = "cpu",
    form: ListedFormat = "table",
) -> None:
    """Measure speed and memory against the budgets; takes a few minutes."""
    with stoppable(keeps=False):
        from baselines.evaluation.bench.gpu import measure_gpu
        from baselines.evaluation.bench.measures import measure
        from baselines.evaluation.bench.tables import gpu_table, report

        console = Console(stderr=True)
        with console.status("") as status:
            tell = status.update if console.is_terminal else lambda _: None
            on_gpu = measure_gpu(quick, tell) if device == "cuda" else []
            measured = {} if on_gpu else measure(quick, threads, tell)
        if form == "json":
            typer.echo(json.dumps(on_gpu or measured, indent=1))
        else:
            Console().print(gpu_table(on_gpu) if on_gpu else report(measured))


app.command("plot")(stoppable(keeps=False)(plot_figure))
app.command()(stoppable()(reproduce))
app.command()(stoppable(keeps=False)(export))
app.command()(stoppable(keeps=False)(watch))
app.command()(stoppable(keeps=False)(play))
app.command(epilog="Example: swarm-forage new weighting my_rule")(new)
