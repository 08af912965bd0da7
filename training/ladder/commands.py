"""The command `swarm-forage benchmark`: the ladder's cards, its runs, and its page."""

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from baselines.cli import ListedFormat, app, stoppable
from baselines.evaluation.common_options import AddressOption, BackendOption, find_backend, path
from baselines.evaluation.console import check_file, say

if TYPE_CHECKING:
    from training.ladder.rungs import Rung
    from training.ladder.runs import Run

benchmark = typer.Typer(
    name="benchmark",
    help="The ladder: tasks of rising difficulty, and algorithms that learn them from scratch.",
    no_args_is_help=True,
)
app.add_typer(benchmark)

OutOption = Annotated[Path, Option(parser=path, help="File of the runs (.parquet).")]
PageOption = Annotated[
    Path | None,
    Option(parser=path, help="Write a page of all runs (.md), and its figures beside it."),
]

RUNS, MARL_EVAL = Path("docs/data/ladder.parquet"), Path("runs/marl_eval.json")

Rungs = Annotated[
    list[str] | None, Option("--rung", metavar="NAME", help="Only this rung; may be repeated.")
]


@benchmark.command("list")
def list_cards(form: ListedFormat = "table") -> None:
    """Show the rungs: what is hard about each, and the scores of random actions and controllers."""
    from rich.console import Console

    from training.ladder.page import tables
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
    workers: Annotated[int, Option(min=1, help="Number of worker processes.")] = 2,
    out: Annotated[Path, Option(parser=path, help="Folder of the episodes.")] = Path("runs/cards"),
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Score random actions, hand-written controllers and oracles, and write scores to the cards."""
    from training.ladder.benchmark import score_references
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
        Option("--algorithm", metavar="NAME", help="Only this algorithm; may be repeated."),
    ] = None,
    seeds: Annotated[int, Option(min=0, help="Trainings of each algorithm; 0: none.")] = 5,
    budget: Annotated[
        int | None,
        Option(min=1, help="Robot-steps of a training.", show_default="the rung's"),
    ] = None,
    workers: Annotated[int, Option(min=1, help="Number of worker processes.")] = 2,
    out: OutOption = RUNS,
    page: PageOption = None,
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Train algorithms on rungs from scratch, score them in test worlds, and draw their curves.

    Every run is added to --out as soon as it has ended; the same command later trains only the
    missing runs. All runs are also written to a file for marl-eval, runs/marl_eval.json.
    """
    from training.ladder.benchmark import jobs_of, run_jobs
    from training.ladder.rungs import find_algorithms, find_named, read_rungs

    known = read_rungs()
    chosen, trained = find_named("rung", rungs, known), find_algorithms(algorithms)
    _check_files(out, page)
    for rung in chosen if seeds else ():
        rung.normalised(0.0)  # fails early if its card has no scores
    spread = find_backend(backend, workers, address=address)
    run_jobs(jobs_of(chosen, trained, seeds, budget), out, spread)
    names = {rung.name for rung in chosen}, {algorithm.name for algorithm in trained}
    for run in _current_runs(page, out):
        if run.rung in names[0] and run.algorithm in names[1]:
            normalised = known[run.rung].normalised(run.score)
            typer.echo(f"{run.rung} {run.algorithm} {run.seed}: {run.score:.1f}, {normalised:.2f}")


@benchmark.command()
@stoppable()
def defaults(
    seeds: Annotated[int, Option(min=1, help="Trainings of each algorithm.")] = 10,
    workers: Annotated[int, Option(min=1, help="Number of worker processes.")] = 2,
    out: OutOption = RUNS,
    page: PageOption = None,
) -> None:
    """Train algorithms with their libraries' defaults on es1, rewarded by round trips alone.

    These are PPO, SAC and DQN of stable-baselines3, PPO with a rollout of 128 decisions of 80
    robots, PPO in CleanRL's style, and, if installed, MAPPO and IPPO of BenchMARL. The runs belong
    to rung es1 of the ladder, and --page writes the page of the ladder.
    """
    from rich.console import Console

    from training.ladder.benchmark import installed, jobs_of, run_jobs
    from training.ladder.page import defaults_table
    from training.ladder.rungs import DEFAULTS, find_algorithms, read_rungs

    _check_files(out, page)
    rung = read_rungs()["es1"]
    jobs = jobs_of([rung], installed(find_algorithms(DEFAULTS)), seeds, None)
    run_jobs(jobs, out, find_backend("joblib", workers))
    runs = _current_runs(page, out)
    own = [run for run in runs if run.rung == rung.name and run.algorithm in DEFAULTS]
    Console().print(defaults_table(rung, own))


def _check_files(out: Path, page: Path | None) -> None:
    """Raise ConfigError if a file of the options cannot be written."""
    if page:
        check_file("--page", page, [".md"])
    check_file("--out", out, [".parquet"])


def _current_runs(page: Path | None, out: Path) -> "Sequence[Run]":
    """Return the runs of the present configurations; write them for marl-eval and to the page."""
    from swarm_forage_env.atomic_write import write_atomically
    from training.ladder.rungs import find_algorithms, read_rungs
    from training.ladder.runs import current, marl_eval, read_runs

    stored, rungs = read_runs(out), list(read_rungs().values())
    runs = current(stored, rungs, find_algorithms(None))
    counted = {(*run.identity, run.key) for run in runs}
    for run in stored:
        if (*run.identity, run.key) not in counted:
            say(
                f"{out}: {run.rung}, {run.algorithm}, seed {run.seed} no longer counts, because"
                " its settings are not those of now; a new run of that length will replace it"
            )
    write_atomically(MARL_EVAL, (json.dumps(marl_eval(runs), indent=1) + "\n").encode())
    if page:
        command = ["swarm-forage", "benchmark", "ladder", f"--out={out}", f"--page={page}"]
        _write_page(page, rungs, runs, shlex.join(command))
    return runs


def _write_page(page: Path, rungs: "Sequence[Rung]", runs: "Sequence[Run]", command: str) -> None:
    from baselines.evaluation.figure_page import check_plot, save_figure
    from swarm_forage_env.atomic_write import write_atomically
    from training.ladder import page as pages
    from training.ladder.figures import curves, profiles
    from training.ladder.runs import by_rung

    folder, groups = page.parent / "images" / "ladder", by_rung(rungs, runs)
    drawn = {rung.name: curves(rung, own, command) for rung, own in groups}
    if runs:
        drawn[pages.PROFILE] = profiles([rung for rung, _ in groups], runs, command)
    for name, figure in drawn.items():
        file = folder / f"{name}.png"
        check_plot(file, "--page")
        save_figure(figure, file, "The ladder")
    write_atomically(page, pages.page(rungs, runs, command).encode())
