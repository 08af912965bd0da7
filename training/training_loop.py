"""A training that goes in steps and is judged in between: the loop around any of them."""

from collections.abc import Callable, Sequence
from typing import Protocol

from training.checkpoint import BEST
from training.experiment import Experiment
from training.policy_file import CurvePoint, Policy, load_policy
from training.progress import Teller


class Course(Protocol):
    """A training under way; all that it depends on is in its checkpoint."""

    @property
    def done(self) -> int:
        """Steps that have ended."""
        ...

    @property
    def curve(self) -> Sequence[CurvePoint]:
        """What the held-back worlds said so far."""
        ...

    def advance(self, teller: Teller) -> str | None:
        """One step, kept in the checkpoint; what is to be said of it."""
        ...

    def evaluate(self) -> CurvePoint:
        """Judge what there is on the held-back worlds, and keep it if it is the best."""
        ...

    def keep_best(self) -> None:
        """Write the best policy so far, with the curve so far."""
        ...


def run(course: Course, experiment: Experiment, step: str, say: Callable[[str], None]) -> Policy:
    """Run a training, or what is left of it, telling how it gets on; the best policy."""
    with Teller(experiment.out, step, say) as teller:
        teller.start(experiment.budget, course.done)
        _evaluate_if_due(course, experiment, teller)
        while course.done < experiment.budget:
            if told := course.advance(teller):
                say(told)
            _evaluate_if_due(course, experiment, teller)
    course.keep_best()
    return load_policy(experiment.out / BEST)


def _evaluate_if_due(course: Course, experiment: Experiment, teller: Teller) -> None:
    """At the start, in between and at the end; what was judged before a stop is not again."""
    last = course.curve[-1].step if course.curve else -experiment.every
    over = course.done >= experiment.budget
    if course.done > last and (over or course.done - last >= experiment.every):
        teller.point(course.evaluate())
