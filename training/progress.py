"""Progress of a training run: lines and a progress bar on stderr, curves for TensorBoard."""

from collections.abc import Callable, Mapping
from pathlib import Path

from baselines.evaluation.console import progress_bar
from training.policy_file import CurvePoint

FOLDER = "tensorboard"


class ProgressLogger:
    """Logs training steps and evaluations; a context manager."""

    def __init__(self, out: Path, unit: str, say: Callable[[str], None]) -> None:
        """Log TensorBoard curves to `out`; a progress bar is drawn if stderr is a terminal."""
        from torch.utils.tensorboard import SummaryWriter

        self._unit = unit
        self._say = say
        self._writer = SummaryWriter(str(out / FOLDER))
        self._progress = progress_bar(f"{unit}s")
        self._bar = self._progress.add_task("", total=None)

    def __enter__(self) -> "ProgressLogger":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()
        self._writer.close()

    def start(self, budget: int, done: int) -> None:
        """Set the total number of steps, and the number found in the checkpoint."""
        self._say(f"{done} of {budget} {self._unit}s found, {max(0, budget - done)} to run")
        self._progress.update(self._bar, total=budget, completed=done)

    def log_scalars(self, step: int, values: Mapping[str, float]) -> None:
        """Log the scalars of one step; those under `speed/` are also shown beside the bar."""
        for name, value in values.items():
            self._writer.add_scalar(name, value, step)
        speeds = {k: v for k, v in values.items() if k.startswith("speed/")}
        told = ", ".join(f"{v:.3g} {k.removeprefix('speed/')}" for k, v in speeds.items())
        self._progress.update(self._bar, completed=step, description=told)

    def log_evaluation(self, point: CurvePoint) -> None:
        """Log an evaluation on the held-back seeds, and print it."""
        step = int(point.step)
        self._writer.add_scalar("held_back/value", point.value, step)
        for name, trips in point.round_trips.items():
            self._writer.add_scalar(f"held_back/{name}", trips.mean, step)
        self._writer.flush()
        told = ", ".join(f"{name} {trips.mean:.1f}" for name, trips in point.round_trips.items())
        self._say(f"{self._unit} {step}: held-back round trips {told}; value {point.value:.4f}")
