"""Search the numbers that the papers leave open for a set that gives the published results.

    python -m baselines.papers.search_parameters --trials 300

A set is measured in es1, es2 and es3. Each claim adds to its score, zero where it holds,

    |ln(ours / nearest end of the published range)|

Source: TR, Section 6 (claims); Watanabe 2023 (sampler: a tree-structured Parzen estimator).
Not in the paper: the ranges, and which claims a trial can afford (`affordable_claims`).
"""

import hashlib
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from typer import Option

from baselines.cli import run, stoppable
from baselines.controllers import SINGLE, SUBSUMPTION
from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.common_options import SettingsOption, path
from baselines.evaluation.console import say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import evaluate
from baselines.papers.claim_types import ClaimResult, RangeClaim, miss
from baselines.papers.experiments import Experiment
from baselines.papers.report import claims_table
from baselines.papers.social_odometry import AFFORDABLE, affordable_claims
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import missing_told
from swarm_forage_env.registry import SCENARIOS

with missing_told():
    import optuna
    from optuna.distributions import FloatDistribution as Float
    from optuna.distributions import IntDistribution as Int
    from optuna.trial import TrialState
    from sqlalchemy.exc import DBAPIError, SQLAlchemyError

FIT_SEED, REPORT_SEED = 5000, 6000  # first worlds that a set is fitted to, and is reported on
WORLDS = {"es1": 6, "es2": 1, "es3": 1}  # of a trial: about as many robots in every arena
OUT = Path("runs/search")

app = typer.Typer(name="python -m baselines.papers.search_parameters", add_completion=False)
ENDED = TrialState.COMPLETE, TrialState.PRUNED
RANGES: Mapping[str, Float | Int] = {
    "robot.cruise_speed": Float(0.03, 0.065),  # slower: few trips; faster: too many in es1
    "sensors.wheel_noise": Float(0.03, 0.12),  # half to twice 20 % of 10 ms (ANTS 4.1)
    "radio.exchange_time": Float(0.1, 1.0),  # two areas take six frames of 9.2 ms; ten times that
    "radio.frames": Int(1, 10),  # no more than ten words of 9.2 ms fit into a tick
    "estimator.refractory": Float(5.0, 40.0),  # a meeting of two robots; a trip of es1
    "estimator.pause": Float(0.0, 25.0),  # half a trip of es1
    "estimator.deaf_when_lost": Float(0.0, 10.0),  # 0.4 m from those who err too
    "estimator.lost_within": Float(0.03, 0.08),  # a few ticks' path; less than the area's radius
    "estimator.overshoot": Float(0.0, 0.25),  # an area's diameter and a body's radius
    "motion.gap": Float(0.004, 0.04),  # contact; the proximity sensors read nothing beyond
    "motion.swerve": Float(1.63, 2.0),  # below pi/2 into the wall; above 2.0 back on its way
    "motion.hold": Float(0.0, 0.8),  # as long as passing a robot takes
    "motion.mean_run": Float(0.2, 2.0),  # a few body lengths; the length of the smallest arena
    "es1.area_distance": Float(0.8, 1.5),  # above 0.6 (start circle); at 1.5 areas touch the walls
    "es2.area_distance": Float(1.25, 3.0),  # above 1.2 (start circle); 2.5 times 1.2, as the arena
    "es3.area_distance": Float(1.5, 3.5),  # a trip's period is at most 1.2 times that of es2
}
"""The open parameters, SI units: what a robot or its surroundings allow, narrowed to where robots
forage at all. An arena's `area_distance` is its own, all else holds in every arena."""

ES1 = SCENARIOS["es1"]
PARTS = {"robot": ES1.robot, "sensors": ES1.sensors, "radio": ES1.radio}
LAYERS = {"estimator": SINGLE, "motion": SUBSUMPTION}
TASKS = {arena: SCENARIOS[arena].task for arena in WORLDS}
Values = Mapping[str, float]


def defaults() -> dict[str, float]:
    """The present value of every parameter."""
    names = {name: name.split(".") for name in RANGES}
    return {k: getattr((PARTS | LAYERS | TASKS)[part], field) for k, (part, field) in names.items()}


@dataclass(frozen=True)
class Runner:
    """Measures sets; an episode that the dataset holds is not run again."""

    dataset: Dataset
    workers: int
    physics: str
    settings: tuple[str, ...]

    def configurations(self, values: Values, arena: str) -> list[ExperimentConfig]:
        """A configuration of each controller in an arena with these values."""
        numbers = {name: f"{name}={value!r}" for name, value in values.items()}
        layers = ",".join(v for k, v in numbers.items() if k.startswith(tuple(LAYERS)))
        world = [v for k, v in numbers.items() if k.startswith(tuple(PARTS))]
        world.append(numbers[f"{arena}.area_distance"].replace(arena, "task"))
        labels = (f"{each}{',' if ':' in each else ':'}{layers}" for each in AFFORDABLE)
        each = (Experiment(arena, label, (*world, *self.settings)) for label in labels)
        return [experiment.configuration(self.physics) for experiment in each]

    def judge(self, values: Values, arena: str, seeds: range) -> dict[RangeClaim, ClaimResult]:
        """Judge the claims of an arena in the worlds of these seeds."""
        wanted, n = self.configurations(values, arena), len(seeds)
        episodes = evaluate(wanted, seeds, self.dataset, JoblibBackend(self.workers))
        cells = (episodes[start : start + n] for start in range(0, len(episodes), n))
        results = {Experiment(arena, each): next(cells) for each in AFFORDABLE}
        return {claim: claim.judge(results) for claim in affordable_claims(arena)}


def rounded(params: Mapping[str, float]) -> dict[str, float]:
    """A set of no more digits than will be written down."""
    return {k: v if isinstance(v, int) else float(f"{v:.3g}") for k, v in params.items()}


def search(study: optuna.Study, runner: Runner, trials: int, seed: int) -> None:
    """Run trials until the study holds `trials`; one beyond the third best score is stopped."""
    while (ended := len(study.get_trials(states=ENDED))) < trials:
        draws = (seed * 1_000_003 + ended) % 2**32  # a search that goes on draws new sets
        study.sampler = optuna.samplers.TPESampler(seed=draws, multivariate=True)
        best = sorted(each.value or 0.0 for each in study.get_trials(states=ENDED[:1]))
        limit = best[2] if len(best) > 2 else math.inf
        trial, total = study.ask(dict(RANGES)), 0.0
        for step, (arena, n) in enumerate(WORLDS.items()):
            if total <= limit:
                seeds = range(FIT_SEED, FIT_SEED + n)
                judged = runner.judge(rounded(trial.params), arena, seeds)
                total += sum(miss(claim, each.ours) for claim, each in judged.items())
                trial.report(total, step)
        stopped = total > limit
        study.tell(trial, None if stopped else total, ENDED[stopped])
        say(f"trial {trial.number}: score {total:.3f}{' or more' if stopped else ''}")


def open_study(address: str, name: str) -> optuna.Study:
    """The study in a database, whose tables another process may be making at the same moment."""
    for pause in (1.0, 2.0, 4.0):
        try:
            return optuna.create_study(storage=address, study_name=name, load_if_exists=True)
        except DBAPIError:
            time.sleep(pause)
    return optuna.create_study(storage=address, study_name=name, load_if_exists=True)


def best_set(address: str, runner: Runner, trials: int, seed: int) -> dict[str, float]:
    """The best of the trials in a database once it holds `trials`; the defaults without any."""
    keys = [each.key for arena in WORLDS for each in runner.configurations(defaults(), arena)]
    name = hashlib.sha256(repr(keys).encode() + Path(__file__).read_bytes()).hexdigest()[:16]
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    try:
        study = open_study(address, name)
        if not study.trials:
            study.enqueue_trial(defaults())
        search(study, runner, trials, seed)
        return rounded(study.best_params) if study.get_trials(states=ENDED[:1]) else defaults()
    except (optuna.exceptions.StorageInternalError, SQLAlchemyError, ImportError) as error:
        reason = str(error.__cause__ or error).splitlines()[0]
        raise ConfigError(f"--storage: {reason}; name a database that can be written") from None


@app.command()
@stoppable()
def command(  # noqa: PLR0913 the options of a command
    trials: Annotated[int, Option(min=0, help="Sets in all, those tried included.")] = 300,
    report: Annotated[int, Option(min=0, help="Other worlds to judge the best set in.")] = 0,
    seed: Annotated[int, Option(min=0, help="Seed of the search.")] = 0,
    physics: Annotated[str, Option(help="Engine: rigid or kinematic.")] = "kinematic",
    workers: Annotated[int, Option(min=1, help="Processes to run episodes in.")] = 2,
    settings: SettingsOption = None,
    out: Annotated[Path, Option(parser=path, help="Folder of the episodes.")] = OUT,
    storage: Annotated[
        str, Option(metavar="URL", help="Database of trials.", show_default="a file in --out")
    ] = "",
) -> None:
    """Search one set of open parameters for es1, es2 and es3; the same command goes on later.

    Processes that share a --storage search together, each with a --seed of its own.
    """
    runner = Runner(Dataset(out / "episodes"), workers, physics, tuple(settings or ()))
    runner.dataset.open()
    address = storage or f"sqlite:///{out / 'trials.sqlite'}?timeout=60"
    values = best_set(address, runner, trials, seed)
    table = Table("parameter", "value", "default", "from", "to", box=None)
    for name, each in RANGES.items():
        row = values[name], defaults()[name], each.low, each.high
        table.add_row(name, *map("{:.3g}".format, row))
    Console().print(table)
    worlds, first = (dict.fromkeys(WORLDS, report), REPORT_SEED) if report else (WORLDS, FIT_SEED)
    judged = (runner.judge(values, k, range(first, first + n)) for k, n in worlds.items())
    Console().print(claims_table([result for each in judged for result in each.values()]))


if __name__ == "__main__":
    raise SystemExit(run(commands=app))
