"""The training loop of every algorithm: step, evaluate on held-back seeds, save the best."""

from collections.abc import Callable, Sequence
from typing import Protocol

from training.checkpoint import BEST_POLICY
from training.experiment import Experiment
from training.policy_file import CurvePoint, Policy, load_policy
from training.progress import ProgressLogger


class Training(Protocol):
    """A training run that resumes from its checkpoint, which `evaluate` saves at the latest."""

    @property
    def done(self) -> int:
        """Training steps completed so far."""
        ...

    @property
    def curve(self) -> Sequence[CurvePoint]:
        """Learning curve so far: evaluations on the held-back seeds."""
        ...

    def advance(self, progress: ProgressLogger) -> str | None:
        """Run one training step, and return a line to print, if any."""
        ...

    def evaluate(self) -> CurvePoint:
        """Evaluate the current policy on the held-back seeds, and save it if it is the best."""
        ...

    def save_best(self) -> None:
        """Write the best policy so far, with the learning curve on its card."""
        ...


def run(
    training: Training, experiment: Experiment, step: str, say: Callable[[str], None]
) -> Policy:
    """Run or resume a training until its budget is spent, and return the best policy."""
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
    """Evaluate at the start, every `experiment.every` steps and at the end, once each."""
    last = training.curve[-1].step if training.curve else -experiment.every
    over = training.done >= experiment.budget
    if training.done > last and (over or training.done - last >= experiment.every):
        progress.log_evaluation(training.evaluate())
