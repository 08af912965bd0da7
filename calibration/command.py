"""The command `python -m calibration`: search the open parameters, report on the best set."""

import json
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from baselines.cli import run, stoppable
from baselines.evaluation.backend_options import (
    AddressOption,
    BackendName,
    BackendOption,
    find_backend,
)
from baselines.evaluation.backends import Backend
from baselines.evaluation.common_options import path
from baselines.evaluation.console import progress_bar, say
from baselines.evaluation.evaluate_options import check_physics
from baselines.evaluation.experiment_config import parse_settings
from calibration import boids_gains, tables
from calibration.kept import CountedDataset, checked_trials, trials_address
from calibration.ranges import Values, defaults
from calibration.runner import CalibrationRunner, all_arenas, estimates, sensitivity
from calibration.search import BestTrial, Search
from calibration.source_edits import source_edits
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError

app = typer.Typer(
    name="python -m calibration",
    add_completion=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)

SOCIAL_TRIALS, BOIDS_TRIALS = 300, 60
"""Default number of sets to try."""


class Paper(StrEnum):
    """The papers whose open parameters can be searched."""

    SOCIAL_ODOMETRY = "social-odometry"
    BOIDS = "boids"


@app.command()
@stoppable()
def calibrate(  # noqa: PLR0913 the options of a command
    paper: Annotated[Paper, typer.Argument(help="Whose open parameters to search.")],
    trials: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Sets to try in all, those already tried included.",
            show_default="300; for boids 60, for each filter and group size",
        ),
    ] = None,
    hours: Annotated[
        float | None, typer.Option(min=0.0, help="Start no trial after so long.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Processes to run episodes in.")] = 2,
    threads: Annotated[
        int, typer.Option(min=1, help="Threads that the worlds of a process are spread over.")
    ] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path,
            help="Folder of trials, episodes and results.",
            show_default="runs/calibrate-<paper>",
        ),
    ] = None,
    storage: Annotated[
        str | None,
        typer.Option(
            metavar="URL",
            help="Database of the trials, which processes on several machines may share.",
            show_default="an SQLite file in --out",
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Change a number of every scenario."),
    ] = None,
    physics: Annotated[str, typer.Option(help="Engine: rigid or kinematic.")] = "kinematic",
    report: Annotated[
        int, typer.Option(min=0, help="Report on so many other worlds of each arena.")
    ] = 0,
    with_sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Vary each parameter of the best set alone.")
    ] = False,
    backend: BackendOption = BackendName.JOBLIB,
    address: AddressOption = None,
) -> None:
    """Search what the papers leave open for one set of values that gives the published results.

    For boids, search the static gains of each filter and group size, as that paper meant to;
    of the options, --trials, --seed, --workers, --backend, --address, --storage and --out apply.

    Every trial is kept in the folder --out; the same command later goes on from there. With
    `--trials 0` nothing is searched: `--report 30` and `--sensitivity` then speak of the best
    set found so far, or of the defaults if there is none. What becomes a default is changed by
    hand: the lines are printed.

    Several processes search together that are given the same --storage, and each a --seed and a
    folder --out of its own; --trials is for all of them.
    """
    check_physics(physics)
    spread = find_backend(backend, workers, threads, address)
    out = out or Path("runs") / f"calibrate-{paper.value}"
    if paper is Paper.BOIDS:
        given = {
            "--hours": hours is not None,
            "--threads": threads != 1,
            "--set": bool(settings),
            "--physics": physics != "kinematic",
            "--report": bool(report),
            "--sensitivity": with_sensitivity,
        }
        if wrong := [name for name, is_given in given.items() if is_given]:
            raise ConfigError(f"{', '.join(wrong)}: for social-odometry only, not for boids")
        _boids(BOIDS_TRIALS if trials is None else trials, seed, spread, out, storage)
        return
    trials = SOCIAL_TRIALS if trials is None else trials
    dataset = CountedDataset(out / "episodes")
    runner = CalibrationRunner(
        dataset,
        physics,
        spread,
        settings=parse_settings(settings or []),
    )
    identity = runner.identity
    dataset.open()
    if trials:
        with checked_trials(trials_address(out / "trials.sqlite", storage)):
            search = Search(out, runner, identity, seed, storage)
            try:
                _run(search, trials, hours)
            finally:
                search.close()
    values, title = defaults(), "The defaults; no trial has ended yet"
    if best := BestTrial.read(out / "best.json"):
        title = f"The best set: trial {best.trial}, score {best.score:.3f} ({out / 'best.json'})"
        values = best.values
    _show(values, title, runner)
    if report:
        _report(values, runner, report, out)
    if with_sensitivity:
        _sensitivity(values, runner, out)
    dataset.check()


def _boids(trials: int, seed: int, backend: Backend, out: Path, storage: str | None) -> None:
    """The best static gains of each filter and group size, and what they are worth."""
    if not trials:
        raise ConfigError("--trials=0: boids need at least one")
    dataset = CountedDataset(out / "episodes")
    dataset.open()
    with checked_trials(trials_address(out / "boids.sqlite", storage)):
        found = list(boids_gains.search_gains(dataset, trials, seed, backend, say, storage))
    say(f"report: {boids_gains.REPORT_TRIALS} other worlds")
    worths = [boids_gains.compare_with_unit_gains(dataset, each, backend) for each in found]
    say(str(boids_gains.write_gains(out, found)))
    _print("Static gains, that of the goal being one", tables.gains_table(found, worths))
    dataset.check()


def _run(search: Search, trials: int, hours: float | None) -> None:
    """Search, with a line for each trial on stderr, and a bar if it is a terminal."""
    with progress_bar("trials") as progress:
        bar = progress.add_task("", total=trials, completed=search.n_ended)

        def tell(line: str) -> None:
            best = search.best
            found = f"best {best.score:.3f} (trial {best.trial})" if best else ""
            progress.update(bar, completed=search.n_ended, description=found)
            say(f"{line}; {found}" if found else line)

        say(f"{search.n_ended} of {trials} trials found in {search.folder}")
        search.run(trials, hours, tell)


def _show(values: Values, title: str, runner: CalibrationRunner) -> None:
    """A set, what it measures in the worlds of the search, and the lines to change."""
    say("measuring the set; what is kept is not run again")
    measured = all_arenas(values, runner)
    _print(title, tables.values_table(values))
    _print("In the worlds of the search", tables.fit_table(measured))
    if edits := list(source_edits(values)):
        typer.echo("To make it the default, change these lines:\n")
        for edit in edits:
            typer.echo(str(edit))


def _report(values: Values, runner: CalibrationRunner, worlds: int, out: Path) -> None:
    """A set in worlds that none was fitted to."""
    say(f"report: {worlds} other worlds of each arena")
    found = estimates(values, runner.on_report_worlds(worlds))
    _write(out / "report.json", tables.rows(found))
    _print(f"In {worlds} other worlds of each arena", tables.report_table(found))


def _sensitivity(values: Values, runner: CalibrationRunner, out: Path) -> None:
    """Each parameter varied alone, in the worlds of the search."""
    base = all_arenas(values, runner)
    varied = []
    for each in sensitivity(values, runner):
        say(f"sensitivity: {each.parameter} = {each.value:g}")
        varied.append(each)
    _write(out / "sensitivity.json", tables.sensitivity_rows(base, varied))
    table = tables.sensitivity_table(base, varied, values)
    _print("Each parameter varied alone: change of the score, and round trips", table)


def _print(title: str, table: Any) -> None:  # noqa: ANN401 anything rich can draw
    console = Console()
    console.print(f"[bold]{title}[/bold]", highlight=False)
    console.print(table)
    console.print()


def _write(file: Path, found: Sequence[dict[str, Any]]) -> None:
    write_atomically(file, (json.dumps(found, indent=1) + "\n").encode())


def run_command() -> int:
    """Run the command and return its exit status."""
    return run(commands=app)
