"""The training loop of every algorithm, with its progress on stderr and for TensorBoard."""

import os
import socket
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from baselines.evaluation.console import progress_bar
from training.checkpoint import BEST_POLICY
from training.experiment import Experiment
from training.policy_file import CurvePoint, Policy, load_policy

FOLDER = "tensorboard"


class EventFile:
    """File of curves that TensorBoard reads.

    The calling thread writes each point: an OSError reaches the training, where TensorBoard's own
    writer prints the traceback of a thread.
    """

    def __init__(self, folder: Path) -> None:
        """Start a file in a folder, which is made."""
        name = f"events.out.tfevents.{time.time_ns()}.{socket.gethostname()}.{os.getpid()}"
        self._file = folder / name
        self._write(file_version="brain.Event:2")

    def add_scalar(self, name: str, value: float, step: int) -> None:
        """Add a point to a curve. OSError, which names the file, where that fails."""
        from tensorboard.compat.proto.summary_pb2 import Summary

        point = Summary.Value(tag=name, simple_value=value)
        self._write(step=step, summary=Summary(value=[point]))

    def _write(self, **fields: Any) -> None:  # noqa: ANN401 fields of an event
        from tensorboard.compat.proto.event_pb2 import Event
        from tensorboard.summary.writer.record_writer import RecordWriter

        event = Event(wall_time=time.time(), **fields)
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with self._file.open("ab", buffering=0) as stream:
                RecordWriter(stream).write(event.SerializeToString())
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self._file)) from error


class ProgressLogger:
    """Logs training steps and evaluations; a context manager."""

    def __init__(self, out: Path, unit: str, say: Callable[[str], None]) -> None:
        """Log TensorBoard curves to `out`; a progress bar is drawn if stderr is a terminal."""
        self._unit = unit
        self._say = say
        self._curves = EventFile(out / FOLDER)
        self._progress = progress_bar(f"{unit}s")
        self._bar = self._progress.add_task("", total=None)

    def __enter__(self) -> "ProgressLogger":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def start(self, budget: int, done: int) -> None:
        """Set the total number of steps, and the number found in the checkpoint."""
        self._say(f"{done} of {budget} {self._unit}s found, {max(0, budget - done)} to run")
        self._progress.update(self._bar, total=budget, completed=done)

    def log_scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Log the scalars of one step; those under `speed/` are also shown beside the bar."""
        for name, value in values.items():
            self._curves.add_scalar(name, value, step)
        speeds = {k: v for k, v in values.items() if k.startswith("speed/")}
        told = ", ".join(f"{v:.3g} {k.removeprefix('speed/')}" for k, v in speeds.items())
        self._progress.update(self._bar, completed=step, description=told)

    def log_evaluation(self, point: CurvePoint) -> None:
        """Log an evaluation on the held-back seeds, and print it."""
        step = int(point.step)
        self._curves.add_scalar("held_back/value", point.value, step)
        for name, trips in point.round_trips.items():
            self._curves.add_scalar(f"held_back/{name}", trips.mean, step)
        told = ", ".join(f"{name} {trips.mean:.1f}" for name, trips in point.round_trips.items())
        self._say(f"{self._unit} {step}: held-back round trips {told}; value {point.value:.4f}")


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
