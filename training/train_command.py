"""The commands `swarm-forage train` and `swarm-forage dataset`: options, defaults and reports."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from typer import Argument, Option

from baselines.cli import app, stoppable
from baselines.evaluation.common_options import (
    AddressOption,
    BackendOption,
    EverySettingsOption,
    FileOption,
    PhysicsOption,
    ScenarioArgument,
    SettingsOption,
    ThreadsOption,
    controller_names,
    find_backend,
)
from baselines.evaluation.console import count_noun, progress_bar, say
from swarm_forage_env.errors import ConfigError

if TYPE_CHECKING:
    from baselines.evaluation.backends import Backend
    from training.experiment import Experiment
    from training.policy_file import Interval


USUAL = {
    "cma": (100, 5, 8),
    "imitation": (10, 2, 24),
    "ppo": (6_000_000, 1_500_000, 8),
    "ppo of everything": (200_000_000, 20_000_000, 64),
    "ppo on a GPU": (500_000_000, 250_000_000, 2048),  # motion or both
}
"""Default budget, interval between evaluations, and number of worlds, by kind of training."""


def _option(text: str, default: str | int) -> object:
    """Return an option whose default depends on others, shown as text or as a column of `USUAL`."""
    if isinstance(default, int):
        default = ", ".join(f"{kind}: {numbers[default]}" for kind, numbers in USUAL.items())
    return Option(help=text, show_default=default)


DEFAULT_CONTROLLER = {
    ("cma", "weighting"): "dsgiff-frequent",
    ("imitation", "weighting"): "dsgiff-frequent",
    ("ppo", "weighting"): "dsgiff-frequent",
    ("cma", "motion"): "ssgiff",
}
"""Default controller of the other layers, by algorithm and layer; else that of `parallel_env`."""


@app.command(epilog="Example: swarm-forage train motion es1 --budget 6000000")
@stoppable()
def train(  # noqa: PLR0913 the options of a command
    layer: Annotated[
        Literal["weighting", "motion", "both", "everything"],
        Argument(help="Layer that the policy replaces; a policy of everything has a memory."),
    ],
    scenarios: Annotated[
        list[str],
        Argument(
            help="One or more, each with its changed parameters: es1 es2 es1:radio.frames=50",
            metavar="SCENARIO",
        ),
    ],
    algorithm: Annotated[
        Literal["cma", "imitation", "ppo"] | None,
        _option(
            "cma: CMA-ES on the round trips of the swarm. imitation: DAgger, supervised by the true"
            " errors of the estimates. ppo: policy gradient.",
            "cma for weighting, else ppo",
        ),
    ] = None,
    seed: Annotated[int, Option(help="Seed of the training, which determines its worlds.")] = 0,
    out: Annotated[
        Path | None,
        FileOption(
            help="Folder of policy, checkpoint and curves.",
            show_default="runs/train-<layer>-<algorithm>",
        ),
    ] = None,
    workers: Annotated[int, Option(help="Number of processes; for ppo, of threads.")] = 2,
    budget: Annotated[
        int | None,
        _option("Length: generations (cma), rounds (imitation) or robot steps (ppo).", 0),
    ] = None,
    every: Annotated[
        int | None,
        _option("Interval of evaluations on held-back seeds: generations, rounds or steps.", 1),
    ] = None,
    worlds: Annotated[
        int | None,
        _option(
            "Number of parallel worlds: for each candidate in each scenario (cma), or of the"
            " smallest swarm (imitation, ppo).",
            2,
        ),
    ] = None,
    held_back: Annotated[
        int, Option(help="Number of held-back seeds of an evaluation, in each scenario.")
    ] = 10,
    population: Annotated[
        int | None,
        _option("Candidates of a generation (cma).", "4 + 3 ln(number of weights)"),
    ] = None,
    controller: Annotated[
        str | None,
        _option(
            "Controller of the other layers; parameters as in `evaluate`. If its own layer is a"
            " learned one, cma and imitation start from that.",
            "weighting: dsgiff-frequent; motion by cma: ssgiff; else ssgikf",
        ),
    ] = None,
    settings: EverySettingsOption = None,
    physics: Annotated[str, Option(help="Engine: rigid or kinematic.")] = "rigid",
    device: Annotated[
        str, Option(help="cpu, or cuda for worlds, and with ppo the learner, on a GPU.")
    ] = "cpu",
    backend: BackendOption = "joblib",
    address: AddressOption = None,
) -> None:
    """Train a policy that replaces a hand-written layer.

    The policy with the best score on held-back (validation) seeds is written to the folder --out
    as best.safetensors, with a card of its training (best.json). The same command later resumes
    from the last checkpoint; with a larger --budget, cma and ppo continue a finished training.
    Watch it with: tensorboard --logdir runs
    """
    from baselines.evaluation.experiment_config import parse_settings
    from training.checkpoint import lock_folder
    from training.experiment import Experiment

    algorithm = algorithm or ("cma" if layer == "weighting" else "ppo")
    if controller and layer == "everything":
        raise ConfigError(
            f"--controller={controller}: runs the layers beside the policy, of which everything"
            " leaves none; leave it out"
        )
    own = f"{algorithm} of {layer}"
    kind = own if own in USUAL else algorithm
    if (device, algorithm) == ("cuda", "ppo") and layer in ("motion", "both"):
        kind = "ppo on a GPU"
    lengths = zip((budget, every, worlds), USUAL[kind], strict=True)
    budget, every, worlds = (usual if given is None else given for given, usual in lengths)
    experiment = Experiment(
        layer=layer,
        scenarios=tuple(scenarios),
        algorithm=algorithm,
        out=out or Path("runs") / f"train-{layer}-{algorithm}",
        seed=seed,
        budget=budget,
        every=every,
        worlds=worlds,
        held_back=held_back,
        population=population,
        settings=parse_settings(settings or []),
        controller=controller or DEFAULT_CONTROLLER.get((algorithm, layer), "ssgikf"),
        physics=physics,
        workers=workers,
        device=device,
    )
    if backend != "joblib" and device != "cpu":
        raise ConfigError(f"--backend={backend}: runs worlds on CPUs; leave out --device={device}")
    experiment.check()
    if backend != "joblib" and experiment.algorithm != "cma":
        raise ConfigError(f"--backend={backend}: needs --algorithm cma")
    spread = find_backend(backend, experiment.workers, address=address)
    with lock_folder(experiment.out):
        outcome = _run(experiment, spread)
    _report(experiment, outcome)


Outcome = tuple["Mapping[str, Interval]", Path, str | None]
"""Score and file of a policy, and the name of a controller that runs it; None if there is none."""


def _run(experiment: "Experiment", backend: "Backend") -> Outcome:
    if experiment.algorithm == "ppo":
        from swarm_forage_env.interface import files_read_by
        from training import ppo

        foreign = ppo.train(experiment, say).policy
        card = foreign.card()
        assert card is not None
        assert card.training is not None
        runs, layers = f"network:{foreign.source}", experiment.base_controller.layers.values()
        if any(map(files_read_by, layers)):  # a card must not name these
            runs += f",controller={experiment.controller}"
        return card.training.score, Path(foreign.source), runs
    from training import cma_es, dagger
    from training.controllers import controller_name, with_learned_layers

    if experiment.algorithm == "imitation":
        policy = dagger.train(experiment, say)
    else:
        policy = cma_es.train(experiment, say, backend)
    learned = with_learned_layers(experiment.base_controller, experiment.layers, policy.source)
    return policy.card.score, policy.source, controller_name(learned)


def _report(experiment: "Experiment", outcome: Outcome) -> None:
    """Print the score and the file of the policy, and the command that tests it on unseen seeds."""
    from swarm_forage_env.controllers import parse_controller
    from training.experiment import TEST_SEEDS

    score, file, runs = outcome
    for name, trips in score.items():
        typer.echo(
            f"{name}: {trips.mean:.1f} round trips ({trips.low:.1f} to {trips.high:.1f})"
            f" on {experiment.held_back} held-back seeds"
        )
    typer.echo(f"policy: {file}")
    if runs:
        scenario, own = parse_controller(experiment.scenarios[0])
        changes = {**experiment.settings, **own}
        words = ["evaluate", scenario, experiment.controller, runs, f"--seed={TEST_SEEDS.start}"]
        words += [f"--set={name}={value}" for name, value in changes.items()]
        words += [f"--physics={experiment.physics}"] if experiment.physics != "rigid" else []
        typer.echo(f"test it: swarm-forage {shlex.join(words)}")
    else:
        typer.echo(
            "test it in Python: training.controllers.with_learned_layers makes a controller that"
            " runs it"
        )


@app.command(epilog="Example: swarm-forage dataset es1 ssgikf random --episodes 10")
@stoppable()
def dataset(  # noqa: PLR0913 the options of a command
    scenario: ScenarioArgument,
    policies: Annotated[
        list[str],
        Argument(
            metavar="POLICY...",
            help="Controllers as in evaluate, policies of other trainers (sb3:model.zip), or"
            " random: uniform in the action space of the environment's defaults, over the layers"
            " of ssgikf.",
            autocompletion=controller_names,
        ),
    ],
    episodes: Annotated[int, Option(help="Number of episodes of each policy.")] = 10,
    seed: Annotated[
        int | None,
        Option(
            help="Seed of the first episode; the others count up from it.",
            show_default="10000, used by no test",
        ),
    ] = None,
    learners: Annotated[
        int | None,
        Option(help="Robots to record of each episode, from start to end.", show_default="all"),
    ] = None,
    out: Annotated[
        Path | None,
        FileOption(
            metavar="FOLDER", help="Folder (Parquet).", show_default="runs/<scenario>-transitions"
        ),
    ] = None,
    settings: SettingsOption = None,
    physics: PhysicsOption = None,
    threads: ThreadsOption = 1,
) -> None:
    """Record transitions for offline learning: observation, action, reward, next observation.

    All policies are recorded in one action space, the commands of the motion in every tick, which
    is exact for each of them. For e-pucks these are wheels, learn="motion", action="wheels",
    decision_period=1, reflexes=False, walk=False; the rewards are the robot's own. The same command
    later records only missing episodes. Read them with training.transitions.read(FOLDER).
    """
    from baselines.evaluation.dataset import folder_name
    from baselines.evaluation.evaluate_options import check_count
    from training.experiment import FIRST_TRAINING_SEED
    from training.transitions import DatasetOptions, Recording, Transitions

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
        f"{count_noun(len(recordings) * episodes, 'episode')}, {rows * episodes:,} transitions,"
        f" {size * episodes / 1e6:,.1f} MB before compression, to {store.name};"
        f" {count_noun(n_missing, 'episode')} to play"
    )
    with progress_bar("episodes") as progress:
        bar = progress.add_task("", total=n_missing)
        for recording, own in zip(recordings, missing, strict=True):
            for done in store.record(recording, own, threads):
                progress.advance(bar, done)
    typer.echo(f"read them: training.transitions.read({store.name!r})")
