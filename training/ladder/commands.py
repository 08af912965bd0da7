"""The command `swarm-forage benchmark`: the ladder's cards, its runs, and its page."""

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from baselines.cli import ListedFormat, stoppable
from baselines.evaluation.common_options import AddressOption, BackendOption, find_backend, path

if TYPE_CHECKING:
    from training.ladder.rungs import Rung
    from training.ladder.runs import Run

benchmark = typer.Typer(
    name="benchmark",
    help="The ladder: tasks of rising difficulty, and algorithms that learn them from scratch.",
    no_args_is_help=True,
)

DEFAULTS = ("sb3_ppo", "sb3_ppo_defaults", "sb3_sac", "sb3_dqn")
"""The algorithms that `defaults` trains."""

Rungs = Annotated[
    list[str] | None, Option("--rung", metavar="NAME", help="Only this one; may be repeated.")
]


@benchmark.command("list")
def list_cards(form: ListedFormat = "table") -> None:
    """Show the rungs: what is hard about each, and what random actions and others score."""
    from rich.console import Console

    from training.ladder.cards import tables
    from training.ladder.rungs import read_algorithms, read_rungs

    rungs = list(read_rungs().values())
    if form == "json":
        tree = [
            {"name": each.name, "keywords": each.keywords, **each.card.model_dump()}
            for each in rungs
        ]
        typer.echo(json.dumps(tree, indent=1))
    else:
        Console().print(tables(rungs, list(read_algorithms().values())))


@benchmark.command()
@stoppable()
def cards(
    rungs: Rungs = None,
    missing: Annotated[
        bool, Option("--missing", help="Only rungs whose cards have no scores yet.")
    ] = False,
    workers: Annotated[int, Option(min=1, help="Processes to run episodes in.")] = 2,
    out: Annotated[Path, Option(parser=path, help="Folder of the episodes.")] = Path("runs/cards"),
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Score random actions, hand-written controllers and oracles, and write it on the cards."""
    from training.ladder.cards import score_references
    from training.ladder.rungs import find_named, read_rungs

    chosen = find_named("rung", rungs, read_rungs())
    spread = find_backend(backend, workers, address=address)
    for rung in [each for each in chosen if not (missing and each.card.scores)]:
        for name, score in score_references(rung, out, spread).items():
            typer.echo(f"{rung.name} {name}: {score.mean:.1f}")


@benchmark.command()
@stoppable()
def ladder(  # noqa: PLR0913 the options of a command
    rungs: Rungs = None,
    algorithms: Annotated[
        list[str] | None,
        Option("--algorithm", metavar="NAME", help="Only this one; may be repeated."),
    ] = None,
    seeds: Annotated[int, Option(min=0, help="Trainings of each; 0: none anew.")] = 5,
    budget: Annotated[
        int | None, Option(min=1, help="Robot-steps of a training.", show_default="the rung's")
    ] = None,
    workers: Annotated[int, Option(min=1, help="Processes to train in.")] = 2,
    out: Annotated[Path, Option(parser=path, help="Folder of the runs.")] = Path("runs/ladder"),
    page: Annotated[
        Path | None,
        Option(parser=path, help="Write a page of all runs (.md), with its figures beside it."),
    ] = None,
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Train algorithms on rungs from scratch, score them in test worlds, and draw their curves.

    Every run is kept in --out as soon as it has ended; the same command later makes only those
    that are missing. There is also one file for marl-eval of all runs, OUT/marl_eval.json.
    """
    from baselines.evaluation.console import check_file
    from training.ladder.benchmark import jobs_of, run_jobs
    from training.ladder.rungs import find_algorithms, find_named, read_rungs
    from training.ladder.runs import marl_eval, read_runs, write_json

    known = read_rungs()
    chosen, trained = find_named("rung", rungs, known), find_algorithms(algorithms)
    if page:
        check_file("--page", page, [".md"])
    for rung in chosen if seeds else ():
        rung.normalised(0.0)  # tells early that its card has no scores
    spread = find_backend(backend, workers, address=address)
    run_jobs(jobs_of(chosen, trained, seeds, budget), out, spread)
    runs = read_runs(out, list(known.values()), find_algorithms(None))
    write_json(marl_eval(runs), out / "marl_eval.json")
    if page:
        _check_loses_nothing(page, len(runs), out)
        _write_page(page, list(known.values()), runs, out)
    for run in read_runs(out, chosen, trained):
        normalised = known[run.rung].normalised(run.score)
        typer.echo(f"{run.rung} {run.algorithm} {run.seed}: {run.score:.1f}, {normalised:.2f}")


@benchmark.command()
@stoppable()
def defaults(
    seeds: Annotated[int, Option(min=1, help="Trainings of each.")] = 10,
    workers: Annotated[int, Option(min=1, help="Processes to train in.")] = 2,
    out: Annotated[Path, Option(parser=path, help="Folder of the runs.")] = Path("runs/ladder"),
) -> None:
    """What trainers learn by their libraries' defaults on es1, from round trips alone.

    PPO, SAC and DQN of stable-baselines3, and PPO with a rollout of 128 decisions of 80 robots. The
    runs are kept in --out, as those of the ladder, whose rung es1 they are.
    """
    from rich.console import Console

    from training.ladder.benchmark import jobs_of, run_jobs
    from training.ladder.page import results_table
    from training.ladder.rungs import find_algorithms, read_rungs
    from training.ladder.runs import read_runs

    rung, algorithms = read_rungs()["es1"], find_algorithms(DEFAULTS)
    run_jobs(jobs_of([rung], algorithms, seeds, None), out, find_backend("joblib", workers))
    Console().print(results_table(rung, read_runs(out, [rung], algorithms)))


def _check_loses_nothing(page: Path, n_runs: int, out: Path) -> None:
    """ConfigError if a page reports more runs than there are now."""
    from swarm_forage_env.errors import ConfigError
    from training.ladder.page import runs_told_of

    n_before = runs_told_of(page.read_text("utf-8")) if page.exists() else 0
    if n_before > n_runs:
        raise ConfigError(
            f"--page={page}: tells of {n_before} runs, and {out} holds {n_runs} of the rungs as"
            " they are now, so that results would be lost; name the folder of those runs by --out,"
            " or another page"
        )


def _write_page(page: Path, rungs: "Sequence[Rung]", runs: "Sequence[Run]", out: Path) -> None:
    from baselines.evaluation.figure_page import check_plot, save_figure
    from swarm_forage_env.atomic_write import write_atomically
    from training.ladder import page as pages
    from training.ladder.figures import curves, profiles
    from training.ladder.runs import by_rung

    command = shlex.join(["swarm-forage", "benchmark", "ladder", f"--out={out}", f"--page={page}"])
    folder, groups = page.parent / "images" / "ladder", by_rung(rungs, runs)
    drawn = {
        rung.name: curves(rung, groups[rung.name], command) for rung in rungs if rung.name in groups
    }
    if runs:
        drawn[pages.PROFILE] = profiles(
            [rung for rung in rungs if rung.name in groups], runs, command
        )
    for name, figure in drawn.items():
        file = folder / f"{name}.png"
        check_plot(file, "--page")
        save_figure(figure, file, command, "The ladder")
    write_atomically(page, pages.page(rungs, runs, command).encode())


def add_benchmark(app: typer.Typer) -> None:
    """Add the command to an application; a second call does nothing."""
    if all(each.typer_instance is not benchmark for each in app.registered_groups):
        app.add_typer(benchmark)
