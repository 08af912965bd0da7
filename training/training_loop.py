"""A training that goes in steps and is judged in between: the loop around any of them."""

from collections.abc import Callable, Sequence
from typing import Protocol

from training.checkpoint import BEST_POLICY
from training.experiment import Experiment
from training.policy_file import CurvePoint, Policy, load_policy
from training.progress import ProgressLogger


class Training(Protocol):
    """A training under way; all that it depends on is in its checkpoint."""

    @property
    def done(self) -> int:
        """Steps that have ended."""
        ...

    @property
    def curve(self) -> Sequence[CurvePoint]:
        """What the held-back worlds said so far."""
        ...

    def advance(self, progress: ProgressLogger) -> str | None:
        """One step, kept in the checkpoint; what is to be said of it."""
        ...

    def evaluate(self) -> CurvePoint:
        """Judge what there is on the held-back worlds, and keep it if it is the best."""
        ...

    def save_best(self) -> None:
        """Write the best policy so far, with the curve so far."""
        ...


def run(
    training: Training, experiment: Experiment, step: str, say: Callable[[str], None]
) -> Policy:
    """Run a training, or what is left of it, telling how it gets on; the best policy."""
    with ProgressLogger(experiment.out, step, say) as progress:
        progress.start(experiment.budget, training.done)
        _evaluate_if_due(training, experiment, progress)
        while training.done < experiment.budget:
            if told := training.advance(progress):
                say(told)
            _evaluate_if_due(training, experiment, progress)
    training.save_best()
    return load_policy(experiment.out / BEST_POLICY)


def _evaluate_if_due(training: Training, experiment: Experiment, progress: ProgressLogger) -> None:
    """At the start, in between and at the end; what was judged before a stop is not again."""
    last = training.curve[-1].step if training.curve else -experiment.every
    over = training.done >= experiment.budget
    if training.done > last and (over or training.done - last >= experiment.every):
        progress.log_evaluation(training.evaluate())
