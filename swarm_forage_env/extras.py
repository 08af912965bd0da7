"""Extras: which of them brings a package, and so what to install where that is missing."""

from collections.abc import Iterator
from contextlib import contextmanager

EXTRAS = {
    "evaluate": {"joblib", "matplotlib", "pyarrow", "rich", "scipy", "typer", "yaml"},
    "calibrate": {"optuna"},
    "render": {"imageio_ffmpeg", "pygame"},
    "train": {"cmaes", "safetensors", "stable_baselines3", "tensorboard", "torch"},
    "onnx": {"onnxruntime"},
    "cuda": {"numba_cuda"},
    "ray": {"ray"},
    "torchrl": {"benchmarl", "torch", "torchrl"},
}
"""What each extra brings beside those that it builds on."""


def remedy(module: str | None) -> str | None:
    """The command that installs a missing module; None if no extra brings it.

    >>> remedy("torch.nn")
    "pip install 'swarm-forage[train]'"
    """
    package = (module or "").partition(".")[0]
    extra = next((extra for extra, brought in EXTRAS.items() if package in brought), None)
    return extra and f"pip install 'swarm-forage[{extra}]'"


@contextmanager
def missing_told() -> Iterator[None]:
    """End the program with one line and status 1 if a package that an extra brings is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        install = remedy(error.name)
        if install is None:
            raise
        raise SystemExit(f"swarm-forage: this command needs '{error.name}': {install}") from None
