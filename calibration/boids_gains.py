"""Search the static gains of the boids, for each filter and group size, as the paper meant to.

Smith et al. 2021 (BOIDS), Section 3, says that static gains come from a Monte Carlo search; the
authors' code loads them and never uses them, so that the figures show gains of one.

Not in the paper, and chosen here:
- the cost, of which the authors' code has a similar sum with the sign of the success turned:

      J = |P| / |P|_max + e / e_max + (1 - success) + (1 - goals / most)

  with `most` the goals that a robot at full speed would reach, on straight ways of mean length;
- the gain of the goal is one, the others lie between 0 and 2;
- the setting is `corrected`, on the sensors of the authors' code.
"""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import optuna

from baselines.evaluation.backends import Backend
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.runner import evaluate
from baselines.evaluation.statistics import Comparison, compare
from baselines.papers.adaptive_boids import ESTIMATORS, SIZES
from calibration.kept import open_trials, trials_address
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.episode import WaypointEpisode
from swarm_forage_env.waypoints.scenario import WaypointsScenario

GAINS = ("alignment", "separation", "cohesion", "homing")
HIGHEST = 2.0
"""Of a gain that is searched; that of the goal is one."""

DOUBT_MAX, ERROR_MAX = 0.05, 1.0
"""Highest covariance norm and error [m] allowed, of the setting `corrected`."""

MEAN_WAY = 0.5214
"""Mean distance of two points in a square, as a share of its side.

Source: Weisstein, MathWorld, Square Line Picking.
"""

FIT_SEED, REPORT_SEED = 5000, 6000
FIT_TRIALS, REPORT_TRIALS = 20, 100
STARTUP = 10
"""Sets drawn at random before the sampler learns from them."""


@dataclass(frozen=True)
class StaticGains:
    """The best static gains of one estimator and group size, and what they are worth."""

    estimator: str
    n_robots: int
    gains: dict[str, float]
    cost: float
    """On the seeds that they were fitted to."""


def scenario_of(n_robots: int) -> WaypointsScenario:
    """The scenario that gains are fitted in: the authors' sensors, the paper's tolerance."""
    name = f"waypoints-{n_robots:02d}-authors"
    found: WaypointsScenario = find_scenario(name, {"task.tolerance": 0.2})
    return found


def configuration(estimator: str, n_robots: int, gains: dict[str, float]) -> ExperimentConfig:
    """The configuration of static boids with these gains; those left out are one."""
    label = f"boids-static:estimator={estimator},setting=corrected"
    named = find_layered_controller(label)
    controller = named.with_parameters({f"motion.{k}": v for k, v in gains.items()})
    return ExperimentConfig(label, scenario_of(n_robots), controller, "kinematic")


def cost(episode: WaypointEpisode) -> float:
    """The cost J of an episode; a robot that claims nothing succeeds in nothing."""
    scenario = scenario_of(episode.n_robots)
    most = episode.duration_s * scenario.robot.max_speed / (MEAN_WAY * scenario.task.side)
    norm, error = episode.covariance_norm, episode.position_error_m
    assert norm is not None, "static boids have an estimator"
    assert error is not None
    doubt = norm / DOUBT_MAX + error / ERROR_MAX
    return doubt + (1.0 - (episode.success_rate or 0.0)) + (1.0 - episode.goals_per_robot / most)


def costs(
    dataset: Dataset, backend: Backend, each: ExperimentConfig, seeds: Sequence[int]
) -> list[float]:
    """The cost J under each seed."""
    return [cost(episode) for episode in evaluate([each], seeds, dataset, backend)]


def search_gains(
    dataset: Dataset,
    trials: int,
    seed: int,
    backend: Backend,
    tell: Callable[[str], None],
    storage: str | None = None,
) -> Iterator[StaticGains]:
    """Search the best gains for every estimator and size; a search resumes.

    Trials are kept in a file beside the dataset, which must be open, or in the database `storage`.
    """
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    file = dataset.folder.with_name("boids.sqlite")
    kept = open_trials(trials_address(file, storage))
    try:
        for estimator in ESTIMATORS:
            for size in SIZES:
                name = f"{estimator} {size}"
                study = optuna.create_study(storage=kept, study_name=name, load_if_exists=True)
                _run(study, trials, seed, lambda gains: math.fsum(
                    costs(dataset, backend, configuration(estimator, size, gains),  # noqa: B023
                          range(FIT_SEED, FIT_SEED + FIT_TRIALS))
                ) / FIT_TRIALS)  # fmt: skip
                best = study.best_trial
                found = StaticGains(estimator, size, best.params, float(best.values[0]))
                tell(f"{name}: cost {found.cost:.3f}")
                yield found
    finally:
        kept.engine.dispose()


def compare_with_unit_gains(dataset: Dataset, found: StaticGains, backend: Backend) -> Comparison:
    """Compare the cost of the best gains with that of gains of one, on seeds not fitted to."""
    seeds = range(REPORT_SEED, REPORT_SEED + REPORT_TRIALS)
    best = configuration(found.estimator, found.n_robots, found.gains)
    plain = configuration(found.estimator, found.n_robots, {})
    return compare(costs(dataset, backend, best, seeds), costs(dataset, backend, plain, seeds))


def write_gains(folder: Path, found: Sequence[StaticGains]) -> Path:
    """Write all gains to a file."""
    file = folder / "gains.json"
    write_atomically(file, (json.dumps([asdict(each) for each in found], indent=1) + "\n").encode())
    return file


def _run(
    study: optuna.Study, trials: int, seed: int, price: Callable[[dict[str, float]], float]
) -> None:
    done = optuna.trial.TrialState.COMPLETE
    if not study.get_trials(deepcopy=False):
        study.enqueue_trial(dict.fromkeys(GAINS, 1.0))
    while (ended := len(study.get_trials(deepcopy=False, states=(done,)))) < trials:
        study.sampler = optuna.samplers.TPESampler(
            seed=(seed * 1_000_003 + ended) % 2**32, n_startup_trials=STARTUP, multivariate=True
        )
        trial = study.ask()
        gains = {name: round(trial.suggest_float(name, 0.0, HIGHEST), 3) for name in GAINS}
        study.tell(trial, price(gains))
