"""The command `swarm-forage dataset`."""

from pathlib import Path
from typing import Annotated

import typer
from typer import Argument, Option

from baselines.evaluation.common_options import (
    FileOption,
    PhysicsOption,
    ScenarioArgument,
    SettingsOption,
    ThreadsOption,
    controller_names,
)
from baselines.evaluation.console import progress_bar, say


def dataset(  # noqa: PLR0913 the options of a command
    scenario: ScenarioArgument,
    policies: Annotated[
        list[str],
        Argument(
            metavar="POLICY...",
            help="Controllers as in evaluate, policies of other trainers too (sb3:model.zip); and"
            " random: uniform in the action space of the environment's defaults, over the layers"
            " of ssgikf.",
            autocompletion=controller_names,
        ),
    ],
    episodes: Annotated[int, Option(help="Episodes of each policy.")] = 10,
    seed: Annotated[
        int | None,
        Option(
            help="Seed of the first; the others count up from it.", show_default="10000, no test's"
        ),
    ] = None,
    learners: Annotated[
        int | None,
        Option(help="Robots to keep of each episode, each from start to end.", show_default="all"),
    ] = None,
    out: Annotated[
        Path | None,
        FileOption(
            metavar="FOLDER", help="Where to (Parquet).", show_default="runs/<scenario>-transitions"
        ),
    ] = None,
    settings: SettingsOption = None,
    physics: PhysicsOption = None,
    threads: ThreadsOption = 1,
) -> None:
    """Record transitions of policies for offline learning: observation, action, reward, next one.

    All policies are recorded in one action space: what the motion commands in every tick, which is
    exact for each of them. Of e-pucks these are wheels, learn="motion", action="wheels",
    decision_period=1, reflexes=False, walk=False; the rewards are the robot's own. The same command
    later records only what is missing. Read them by training.transitions.read(FOLDER).
    """
    from baselines.evaluation.dataset import folder_name
    from baselines.evaluation.evaluate_options import check_count
    from training.experiment import FIRST_TRAINING_SEED
    from training.transition_recording import DatasetOptions, Recording, Transitions

    check_count("--threads", threads)
    first = FIRST_TRAINING_SEED if seed is None else seed
    request = DatasetOptions(scenario, policies, episodes, first, settings or [], physics)
    seeds = request.seeds()
    recordings = [Recording(each, learners) for each in request.configurations()]
    rows, size = sum(each.n_rows for each in recordings), sum(each.size for each in recordings)
    name = recordings[0].configuration.scenario.name
    store = Transitions(out or Path("runs") / f"{folder_name(name)}-transitions")
    store.open()
    missing = [store.missing_seeds(each, seeds) for each in recordings]
    n_missing = sum(map(len, missing))
    say(
        f"{len(recordings) * episodes} episodes, {rows * episodes:,} transitions,"
        f" {size * episodes / 1e9:.2f} GB before compression, to {store.name}; {n_missing} episodes"
        " to play"
    )
    with progress_bar("episodes") as progress:
        bar = progress.add_task("", total=n_missing)
        for recording, own in zip(recordings, missing, strict=True):
            for done in store.record(recording, own, threads):
                progress.advance(bar, done)
    typer.echo(f"read them: training.transitions.read({store.name!r})")
