"""The console script: the commands of the baselines, and `train`."""

import os
import sys

EXTRAS = {
    "evaluate": {"joblib", "matplotlib", "pyarrow", "rich", "scipy", "typer"},
    "render": {"imageio_ffmpeg", "pygame"},
    "train": {"cmaes", "safetensors", "stable_baselines3", "tensorboard", "torch"},
}
"""What each extra of the commands brings."""

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it."""


def main() -> None:
    """Run one command; one line on stderr if a package it needs is missing."""
    try:
        from baselines.cli import run
        from training.commands import add_commands

        add_commands()
        status = run()
    except ModuleNotFoundError as error:
        extra = _extra(error.name)
        if extra is None:
            raise
        sys.stderr.write(
            f"swarm-forage: this command needs '{error.name}':"
            f" pip install 'swarm-forage[{extra}]'\n"
        )
        status = 1
    except KeyboardInterrupt:
        status = INTERRUPTED
    if status == INTERRUPTED:  # a compiler stopped half-way complains while it is taken down
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())
    sys.exit(status)


def _extra(module: str | None) -> str | None:
    """The extra that brings a module; None if no extra does."""
    package = (module or "").partition(".")[0]
    return next((extra for extra, brought in EXTRAS.items() if package in brought), None)


if __name__ == "__main__":
    main()
