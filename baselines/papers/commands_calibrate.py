"""The command `calibrate`: find the set of values, report on it, say how much each matters."""

import json
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

from swarm_forage_env.errors import ConfigError

if TYPE_CHECKING:
    from baselines.papers.calibration import Search
    from baselines.papers.calibration_ranges import Values
    from baselines.papers.calibration_swarm import CalibrationRunner


SOCIAL_TRIALS, BOIDS_TRIALS = 300, 60
"""Sets tried unless told otherwise."""


class Paper(StrEnum):
    """Whose open parameters are searched."""

    SOCIAL_ODOMETRY = "social-odometry"
    BOIDS = "boids"


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
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder of trials, episodes and results.", show_default="runs/calibrate-<paper>"
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
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Vary each parameter of the best set alone.")
    ] = False,
) -> None:
    """Search what the papers leave open for one set of values that gives the published results.

    For boids, search the static gains of each filter and group size, as that paper meant to;
    of the options, --trials, --seed, --workers and --out apply.

    Every trial is kept in the folder --out; the same command later goes on from there. With
    `--trials 0` nothing is searched: `--report 30` and `--sensitivity` then speak of the best
    set found so far, or of the defaults if there is none. What becomes a default is changed by
    hand: the lines are printed.
    """
    from baselines.evaluation.dataset import Dataset
    from baselines.evaluation.experiment_config import parse_settings
    from baselines.papers.calibration import BestTrial, Search
    from baselines.papers.calibration_ranges import defaults
    from baselines.papers.calibration_swarm import CalibrationRunner
    from swarm_forage_env.physics import ENGINES

    _ = ENGINES[physics]
    out = out or Path("runs") / f"calibrate-{paper.value}"
    if paper is Paper.BOIDS:
        given = {
            "--hours": hours is not None,
            "--set": bool(settings),
            "--physics": physics != "kinematic",
            "--report": bool(report),
            "--sensitivity": sensitivity,
        }
        if wrong := [name for name, is_given in given.items() if is_given]:
            raise ConfigError(f"{', '.join(wrong)}: for social-odometry only, not for boids")
        _boids(BOIDS_TRIALS if trials is None else trials, seed, workers, out)
        return
    trials = SOCIAL_TRIALS if trials is None else trials
    swarm = CalibrationRunner(
        Dataset(out / "episodes"), physics, workers, settings=parse_settings(settings or [])
    )
    identity = swarm.identity
    swarm.dataset.open()
    if trials:
        search = Search(out, swarm, identity, seed)
        try:
            _run(search, trials, hours)
        finally:
            search.close()
    best = BestTrial.read(out / "best.json")
    values, title = defaults(), "The defaults; no trial has ended yet"
    if best:
        title = f"The best set: trial {best.trial}, score {best.score:.3f} ({out / 'best.json'})"
        values = best.values
    _show(values, title, swarm)
    if report:
        _report(values, swarm, report, out)
    if sensitivity:
        _sensitivity(values, swarm, out)


def _boids(trials: int, seed: int, workers: int, out: Path) -> None:
    """The best static gains of each filter and group size, and what they are worth."""
    from baselines.papers import calibration_boids
    from baselines.papers.calibration_report import gains_table

    if not trials:
        raise ConfigError("--trials=0: boids need at least one")
    out.mkdir(parents=True, exist_ok=True)
    found = list(calibration_boids.search(out, trials, seed, workers, _say))
    _say(f"report: {calibration_boids.REPORT_TRIALS} other worlds")
    worths = [calibration_boids.worth(out, each, workers) for each in found]
    _say(str(calibration_boids.keep(out, found)))
    _print("Static gains, that of the goal being one", gains_table(found, worths))


def _run(search: "Search", trials: int, hours: float | None) -> None:
    """Search, with a line for each trial on stderr, and a bar if it is a terminal."""
    console = Console(stderr=True)
    columns = "trials", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "{task.description}"
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        bar = progress.add_task("", total=trials, completed=search.n_ended)

        def tell(line: str) -> None:
            best = search.best
            found = f"best {best.score:.3f} (trial {best.trial})" if best else ""
            progress.update(bar, completed=search.n_ended, description=found)
            _say(f"{line}; {found}" if found else line)

        _say(f"{search.n_ended} of {trials} trials found in {search.folder}")
        search.run(trials, hours, tell)


def _show(values: "Values", title: str, swarm: "CalibrationRunner") -> None:
    """A set, what it measures in the worlds of the search, and the lines to change."""
    from baselines.papers import calibration_lines, calibration_report
    from baselines.papers.calibration_swarm import all_arenas

    _say("measuring the set; what is kept is not run again")
    measured = all_arenas(values, swarm)
    _print(title, calibration_report.values_table(values))
    _print("In the worlds of the search", calibration_report.fit_table(measured))
    if lines := list(calibration_lines.lines(values)):
        typer.echo("To make it the default, change these lines:\n")
        for line in lines:
            typer.echo(str(line))


def _report(values: "Values", swarm: "CalibrationRunner", worlds: int, out: Path) -> None:
    """A set in worlds that none was fitted to."""
    from baselines.papers import calibration_report
    from baselines.papers.calibration_swarm import estimates

    _say(f"report: {worlds} other worlds of each arena")
    found = estimates(values, swarm.elsewhere(worlds))
    _write(out / "report.json", calibration_report.rows(found))
    _print(f"In {worlds} other worlds of each arena", calibration_report.report_table(found))


def _sensitivity(values: "Values", swarm: "CalibrationRunner", out: Path) -> None:
    """Each parameter varied alone, in the worlds of the search."""
    from baselines.papers import calibration_report
    from baselines.papers.calibration_swarm import all_arenas, sensitivity

    base = all_arenas(values, swarm)
    varied = []
    for each in sensitivity(values, swarm):
        _say(f"sensitivity: {each.parameter} = {each.value:g}")
        varied.append(each)
    _write(out / "sensitivity.json", calibration_report.sensitivity_rows(base, varied))
    table = calibration_report.sensitivity_table(base, varied, values)
    _print("Each parameter varied alone: change of the score, and round trips", table)


def _print(title: str, table: Any) -> None:  # noqa: ANN401 anything rich can draw
    console = Console()
    console.print(f"[bold]{title}[/bold]", highlight=False)
    console.print(table)
    console.print()


def _write(file: Path, found: Sequence[dict[str, Any]]) -> None:
    file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def _say(line: str) -> None:
    typer.echo(f"swarm-forage: {line}", err=True)
