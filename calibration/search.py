"""Search the open parameters with a tree-structured Parzen estimator, in resumable trials.

A trial proposes a set and measures it arena by arena, the cheapest first. Since no term of the
score is below zero, the score of the arenas so far is the least the trial can end with: a trial
that is already beyond what the best ones ended with is stopped there.

Source of the sampler: Watanabe 2023 (tree-structured Parzen estimator, multivariate).
"""

import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import optuna
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution
from optuna.trial import FrozenTrial, TrialState

from calibration.kept import open_trials, trials_address
from calibration.ranges import ARENAS, RANGES, ParameterRange, defaults, rounded
from calibration.runner import Objective
from calibration.targets import score
from swarm_forage_env.atomic_write import write_atomically

ELITE = 3
"""A trial goes on while its score so far is below that of the best trial but this many."""

STARTUP = 20
"""Trials drawn at random before the sampler learns from them."""

ENDED = TrialState.COMPLETE, TrialState.PRUNED


class ElitePruner(optuna.pruners.BasePruner):
    """Stops a trial whose score so far is beyond that of the best finished trials."""

    def prune(self, study: optuna.Study, trial: FrozenTrial) -> bool:
        """Whether to stop the trial."""
        complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        ends = sorted(each.value for each in complete if each.value is not None)
        so_far = max(trial.intermediate_values.values(), default=0.0)
        return len(ends) >= ELITE and so_far > ends[ELITE - 1]


@dataclass(frozen=True)
class BestTrial:
    """The best trial of a search, as kept in a file."""

    trial: int
    score: float
    values: dict[str, float]

    def keep(self, file: Path) -> None:
        """Write the set to a file."""
        write_atomically(file, (json.dumps(asdict(self), indent=1) + "\n").encode())

    @classmethod
    def read(cls, file: Path) -> "BestTrial | None":
        """Read the kept trial; None if there is none."""
        return cls(**json.loads(file.read_text(encoding="utf-8"))) if file.exists() else None


class Search:
    """A search: the trials kept in a folder, and the next ones."""

    def __init__(
        self,
        folder: Path,
        objective: Objective,
        identity: str,
        seed: int = 0,
        storage: str | None = None,
    ) -> None:
        """Resume the trials of this identity, or begin with the defaults.

        They are kept in a database in the folder, or in `storage`, which other processes may share.
        """
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.objective = objective
        self.seed = seed
        self.best_file = folder / "best.json"
        self._storage = open_trials(trials_address(folder / "trials.sqlite", storage))
        self._study = optuna.create_study(
            storage=self._storage,
            study_name=identity,
            pruner=ElitePruner(),
            load_if_exists=True,
        )
        if not self._study.get_trials(deepcopy=False):
            self._study.enqueue_trial(rounded(defaults()), skip_if_exists=True)
        if storage is None:  # else another process may be at work on a trial
            self._retry()

    @property
    def n_ended(self) -> int:
        """Number of trials measured to the end, or stopped early."""
        return len(self._study.get_trials(deepcopy=False, states=ENDED))

    @property
    def best(self) -> BestTrial | None:
        """The best trial so far; None before the first one has ended."""
        complete = self._study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        if not complete:
            return None
        first = min(complete, key=_end)
        return BestTrial(first.number, _end(first), rounded(first.params))

    def run(
        self, trials: int, hours: float | None, tell: Callable[[str], None] = lambda _: None
    ) -> None:
        """Run until so many trials have ended, or for so long; report each in a line."""
        until = math.inf if hours is None else time.monotonic() + 3600.0 * hours
        while self.n_ended < trials and time.monotonic() < until:
            tell(self._trial())

    def close(self) -> None:
        """Close the database."""
        self._storage.engine.dispose()

    def _trial(self) -> str:
        """Run one trial and keep it; return its result in a line.

        Its draws depend on the seed and on how many trials have ended, so that a search that
        was killed goes on as if it had not been.
        """
        self._study.sampler = optuna.samplers.TPESampler(
            seed=(self.seed * 1_000_003 + self.n_ended) % 2**32,
            n_startup_trials=STARTUP,
            multivariate=True,
        )
        trial = self._study.ask({each.name: _distribution(each) for each in RANGES})
        parts = self._measure(trial)
        total, whole = math.fsum(parts.values()), len(parts) == len(ARENAS)
        if whole:
            self._study.tell(trial, total)
        else:
            self._study.tell(trial, state=TrialState.PRUNED)
        if self.best:
            self.best.keep(self.best_file)
        told = ", ".join(f"{arena} {part:.2f}" for arena, part in parts.items())
        return f"trial {trial.number}: {total:.3f}{'' if whole else ' stopped'} ({told})"

    def _measure(self, trial: optuna.Trial) -> dict[str, float]:
        """The score of each arena, as far as the trial gets."""
        values, parts = rounded(trial.params), dict[str, float]()
        for step, arena in enumerate(ARENAS):
            measured = self.objective(values, arena)
            parts[arena] = score(measured)
            trial.set_user_attr(arena, list(measured.values()))
            trial.report(math.fsum(parts.values()), step)
            if trial.should_prune():
                break
        return parts

    def _retry(self) -> None:
        """Queue the trial that a kill broke off."""
        for broken in self._study.get_trials(states=(TrialState.RUNNING,)):
            self._study.tell(broken.number, state=TrialState.FAIL)
            if len(broken.params) == len(RANGES):
                self._study.enqueue_trial(broken.params)


def _distribution(each: ParameterRange) -> BaseDistribution:
    if each.whole:
        return IntDistribution(round(each.low), round(each.high))
    return FloatDistribution(each.low, each.high, log=each.log)


def _end(trial: FrozenTrial) -> float:
    return math.inf if trial.value is None else trial.value
