"""How training gets on: lines and a bar on stderr, and curves for TensorBoard."""

from collections.abc import Callable, Mapping
from pathlib import Path

from baselines.evaluation.console import progress_bar
from training.policy import CurvePoint

FOLDER = "tensorboard"


class Teller:
    """Told of every generation and evaluation; use as a context."""

    def __init__(self, out: Path, unit: str, say: Callable[[str], None]) -> None:
        """Curves go to `out`; a bar is drawn if stderr is a terminal."""
        from torch.utils.tensorboard import SummaryWriter

        self._unit = unit
        self._say = say
        self._writer = SummaryWriter(str(out / FOLDER))
        self._progress = progress_bar(f"{unit}s")
        self._bar = self._progress.add_task("", total=None)

    def __enter__(self) -> "Teller":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()
        self._writer.close()

    def start(self, budget: int, done: int) -> None:
        """How many steps there are in all, and how many of them were found."""
        self._say(f"{done} of {budget} {self._unit}s found, {max(0, budget - done)} to run")
        self._progress.update(self._bar, total=budget, completed=done)

    def scalars(self, step: int, values: Mapping[str, float]) -> None:
        """The numbers of one step; those of the speed are shown beside the bar."""
        for name, value in values.items():
            self._writer.add_scalar(name, value, step)
        speeds = {k: v for k, v in values.items() if k.startswith("speed/")}
        told = ", ".join(f"{v:.3g} {k.removeprefix('speed/')}" for k, v in speeds.items())
        self._progress.update(self._bar, completed=step, description=told)

    def point(self, point: CurvePoint) -> None:
        """An evaluation on the held-back worlds."""
        step = int(point.step)
        self._writer.add_scalar("held_back/value", point.value, step)
        for name, trips in point.round_trips.items():
            self._writer.add_scalar(f"held_back/{name}", trips.mean, step)
        self._writer.flush()
        told = ", ".join(f"{name} {trips.mean:.1f}" for name, trips in point.round_trips.items())
        self._say(f"{self._unit} {step}: held-back round trips {told}; value {point.value:.4f}")
