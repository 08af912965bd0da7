"""The arguments and options that several commands have in the same words."""

from pathlib import Path
from typing import Annotated

import typer

from baselines.evaluation.name_completion import scenario_names

ScenarioArgument = Annotated[
    str,
    typer.Argument(
        help="A name (see `swarm-forage list`) or a .toml file.", autocompletion=scenario_names
    ),
]

FirstSeedOption = Annotated[
    int, typer.Option(help="Seed of the first; the others count up from it.")
]

WorkersOption = Annotated[int, typer.Option(help="Processes to run them in.")]

ThreadsOption = Annotated[
    int, typer.Option(help="Threads that the worlds of a process are spread over.")
]

SettingsOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change a number of the scenario."),
]

PhysicsOption = Annotated[
    str | None,
    typer.Option(help="Engine: rigid or kinematic.", show_default="rigid; kinematic for waypoints"),
]


def path(text: str | Path) -> Path:
    """A file or folder of this machine, which an option writes; help calls it by this name.

    BadParameter for an address such as s3://bucket/x, which would make a folder "s3:".
    """
    if "://" in str(text):  # a default is a path already
        raise typer.BadParameter(
            f"{text}: must be a file or folder of this machine; write it here, then copy it to the"
            " address"
        )
    return Path(text)
