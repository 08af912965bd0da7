"""Extras: the packages that each installs, and the remedy for a missing package."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

EXTRAS = {
    "evaluate": {
        "joblib", "matplotlib", "pyarrow", "rich", "safetensors", "scipy", "typer", "yaml",
    },
    "render": {"imageio_ffmpeg", "pygame"},
    "train": {"cmaes", "sb3_contrib", "stable_baselines3", "tensorboard", "torch"},
    "onnx": {"onnxruntime"},
    "cuda": {"numba_cuda"},
    "play": {"ziglang"},
    "ray": {"ray"},
    "torchrl": {"benchmarl", "torch", "torchrl"},
}  # fmt: skip
"""Packages of each extra, without those of extras that it builds on."""


COMMON_NAMES = ("baselines", "training")
"""Other packages of this distribution; foreign packages may have the same names."""


def remedy(module: str | None) -> str | None:
    """Return the command that installs a missing module; None if no extra contains it.

    >>> remedy("torch.nn")
    "pip install 'swarm-forage[train]'"
    """
    package = (module or "").partition(".")[0]
    extra = next((extra for extra, brought in EXTRAS.items() if package in brought), None)
    return extra and f"pip install 'swarm-forage[{extra}]'"


def other_package(module: str | None) -> str | None:
    """Return the remedy if a foreign package hides one of ours; None if none does."""
    package = (module or "").partition(".")[0]
    if package not in COMMON_NAMES:
        return None
    spec = sys.modules[package].__spec__ if package in sys.modules else find_spec(package)
    if spec is None:
        return None
    folder = Path(next(iter(spec.submodule_search_locations or ()), spec.origin or ""))
    if folder.resolve() == Path(__file__).resolve().parents[1] / package:
        return None
    return (
        f"another package named '{package}' is found first, in {folder}; install swarm-forage in an"
        " environment of its own, and start Python in another folder"
    )


@contextmanager
def report_missing() -> Iterator[None]:
    """End the program with one line and status 1 if a package of an extra is missing."""
    try:
        yield
    except ImportError as error:
        if namesake := other_package(error.name):
            raise SystemExit(f"swarm-forage: {namesake}") from None
        install = remedy(error.name) if isinstance(error, ModuleNotFoundError) else None
        if install is None:
            raise
        raise SystemExit(f"swarm-forage: this command needs '{error.name}': {install}") from None
