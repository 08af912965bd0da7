"""Training loop of every algorithm, with progress on stderr and for TensorBoard."""

import os
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np

from baselines.evaluation.backends import Backend
from baselines.evaluation.console import progress_bar
from swarm_forage_env.arrays import Array, Float32, Int64
from training.candidate_rollouts import Architecture, CandidateRollouts
from training.checkpoint import (
    BEST_POLICY,
    CHECKPOINT,
    mean_with_interval,
    read_checkpoint,
    unreadable,
    write_checkpoint,
)
from training.experiment import Experiment, versions
from training.learned_weighting import unflatten
from training.policy_file import (
    Card,
    CurvePoint,
    Interval,
    TrainingRecord,
    Weights,
    arrays_under,
    layer_card,
    save_policy,
)

FOLDER = "tensorboard"
BEST = "best."  # prefix of the best policy's arrays in a checkpoint


def write_event(file: Path, **fields: object) -> None:
    """Append an event to a file of curves that TensorBoard reads; an OSError names the file.

    The calling thread writes, so that an error reaches the training; TensorBoard's own writer only
    prints the traceback of its thread.
    """
    from tensorboard.compat.proto.event_pb2 import Event
    from tensorboard.summary.writer.record_writer import RecordWriter

    event = Event(wall_time=time.time(), **fields)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("ab", buffering=0) as stream:
            RecordWriter(stream).write(event.SerializeToString())
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from error


class ProgressLogger:
    """Context manager that logs training steps and evaluations."""

    def __init__(
        self, out: Path, unit: str, say: Callable[[str], None], budget: int = 0, done: int = 0
    ) -> None:
        """Log TensorBoard curves to `out`; a progress bar is drawn if stderr is a terminal.

        `done` of `budget` steps were found in the checkpoint.
        """
        self._unit, self._say = unit, say
        name = f"events.out.tfevents.{time.time_ns()}.{socket.gethostname()}.{os.getpid()}"
        self._events = out / FOLDER / name
        write_event(self._events, file_version="brain.Event:2")
        self._progress = progress_bar(f"{unit}s")
        self._bar = self._progress.add_task("", total=budget, completed=done)
        say(f"{done} of {budget} {unit}s found, {max(0, budget - done)} to run")

    def __enter__(self) -> "ProgressLogger":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def log_scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Log the scalars of one step; those under `speed/` are also shown beside the bar."""
        speeds = []
        for name, value in values.items():
            self._add_scalar(name, value, step)
            if name.startswith("speed/"):
                speeds.append(f"{value:.3g} {name.removeprefix('speed/')}")
        self._progress.update(self._bar, completed=step, description=", ".join(speeds))

    def log_evaluation(self, point: CurvePoint) -> None:
        """Log an evaluation on the held-back seeds, and print it."""
        step = int(point.step)
        self._add_scalar("held_back/value", point.value, step)
        for name, trips in point.round_trips.items():
            self._add_scalar(f"held_back/{name}", trips.mean, step)
        means = ", ".join(f"{name} {trips.mean:.1f}" for name, trips in point.round_trips.items())
        self._say(f"{self._unit} {step}: held-back round trips {means}; value {point.value:.4f}")

    def _add_scalar(self, name: str, value: float, step: int) -> None:
        from tensorboard.compat.proto.summary_pb2 import Summary

        point = Summary.Value(tag=name, simple_value=value)
        write_event(self._events, step=step, summary=Summary(value=[point]))


class Training(ABC):
    """Training run that resumes from its checkpoint; each evaluation saves one."""

    packages: ClassVar[tuple[str, ...]] = ("torch",)
    """Packages whose versions are recorded on the card, in addition to the usual ones."""
    _best: Weights
    """Weights with the best score on the held-back seeds so far, named as in a policy file."""

    def __init__(self, experiment: Experiment) -> None:
        self._experiment = experiment
        self._file = experiment.out / CHECKPOINT
        self.curve: list[CurvePoint] = []

    @property
    @abstractmethod
    def done(self) -> int:
        """Training steps completed so far."""

    @abstractmethod
    def advance(self, progress: ProgressLogger) -> str | None:
        """Run one training step, and return a line to print, if any."""

    def evaluate(self) -> CurvePoint:
        """Evaluate the current policy on the held-back seeds, and save it if it is the best.

        The best policy has the highest ln(1 + mean round trips), averaged over the scenarios.
        """
        trips = self._round_trips()
        point = CurvePoint(
            step=self.done,
            simulated_s=self._simulated_s,
            value=float(np.mean([np.log1p(each.mean()) for each in trips.values()])),
            round_trips={name: mean_with_interval(each) for name, each in trips.items()},
        )
        if all(point.value > each.value for each in self.curve):
            self._best = self._weights
        self.curve.append(point)
        self._save()
        self.save_best()
        return point

    def save_best(self) -> None:
        """Write the best policy so far, with the learning curve on its card."""
        best = max(self.curve, key=lambda point: point.value)
        self._write(self._experiment.out / BEST_POLICY, self._best, best.round_trips)

    @property
    @abstractmethod
    def _weights(self) -> Weights:
        """Weights of the current policy, named as in a policy file."""

    @property
    @abstractmethod
    def _simulated_s(self) -> float:
        """Simulated time so far, summed over worlds [s]."""

    @property
    @abstractmethod
    def _state(self) -> dict[str, Array]:
        """Arrays of a checkpoint, other than the best weights."""

    @abstractmethod
    def _restore(self, arrays: Mapping[str, Array]) -> None:
        """Restore the arrays of `_state`; `curve` has been restored before."""

    @abstractmethod
    def _round_trips(self) -> Mapping[str, Int64[Array, " worlds"]]:
        """Return the round trips of the current policy in each held-back world, by scenario."""

    def _open(self) -> None:
        """Resume from the checkpoint, or write the first one. ConfigError if it does not match."""
        self._best = self._weights
        if self._file.exists():
            self.curve, arrays = read_checkpoint(self._file, self._experiment.identity)
            try:
                self._restore(arrays)
            except (AssertionError, KeyError, RuntimeError, ValueError) as error:
                raise unreadable(self._file, f"its arrays do not fit: {error}") from None
            self._best = arrays_under(BEST, arrays)
        else:
            self._save()

    def _save(self) -> None:
        arrays = self._state | {BEST + name: array for name, array in self._best.items()}
        write_checkpoint(self._file, self._experiment.identity, self.curve, arrays)

    @abstractmethod
    def _write(self, file: Path, weights: Weights, score: Mapping[str, Interval]) -> None:
        """Write a policy with its card to files."""

    def _record(self, score: Mapping[str, Interval]) -> TrainingRecord:
        experiment = self._experiment
        return TrainingRecord(
            scenarios=experiment.scenarios,
            settings=dict(experiment.settings),
            algorithm=experiment.algorithm,
            command=experiment.command,
            seed=experiment.seed,
            versions=versions(*self.packages),
            curve=tuple(self.curve),
            score=dict(score),
        )


class NetworkTraining(Training):
    """Training of the network of one layer, which is evaluated as a candidate by rollouts."""

    def __init__(
        self,
        experiment: Experiment,
        architecture: Architecture,
        sizes: Mapping[str, int],
        backend: Backend,
    ) -> None:
        """Set up the rollouts; `sizes` are those of the network, as on a card."""
        super().__init__(experiment)
        self._architecture, self._sizes = architecture, sizes
        self._rollouts = CandidateRollouts(
            experiment.scenarios_by_name,
            experiment.base_controller,
            experiment.physics,
            backend,
            architecture,
            experiment.device,
        )

    @property
    @abstractmethod
    def _numbers(self) -> Float32[Array, " numbers"]:
        """Flat weights of the current network."""

    @property
    def _weights(self) -> Weights:
        (layer,) = self._experiment.layers
        arrays = unflatten(self._numbers, self._architecture.shapes(self._sizes))
        return {f"{layer}.{name}": array for name, array in arrays.items()}

    def _round_trips(self) -> Mapping[str, Int64[Array, " worlds"]]:
        seeds = self._experiment.held_back_seeds
        trips = self._rollouts.round_trips(self._numbers[None], seeds)
        return {name: each[0] for name, each in trips.items()}

    def _write(self, file: Path, weights: Weights, score: Mapping[str, Interval]) -> None:
        (layer,) = self._experiment.layers
        scenario = next(iter(self._experiment.scenarios_by_name.values()))
        layers = {layer: layer_card(layer, scenario, self._architecture.name, self._sizes)}
        record = self._record(score).model_dump()
        card = Card(layers=layers, controller=self._experiment.controller, **record)
        save_policy(file, weights, card)


def run(training: Training, experiment: Experiment, step: str, say: Callable[[str], None]) -> Path:
    """Run or resume a training until its budget is spent; return the file of the best policy."""
    with ProgressLogger(experiment.out, step, say, experiment.budget, training.done) as progress:
        while True:  # evaluate at the start, every `experiment.every` steps and at the end
            last = training.curve[-1].step if training.curve else -experiment.every
            over = training.done >= experiment.budget
            if training.done > last and (over or training.done - last >= experiment.every):
                progress.log_evaluation(training.evaluate())
            if over:
                break
            if line := training.advance(progress):
                say(line)
    training.save_best()
    return experiment.out / BEST_POLICY
