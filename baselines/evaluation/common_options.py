"""Arguments and options that several commands share, and their completion."""

from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from typer import Argument, Option

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.registry import CONTROLLERS, POLICIES, REFERENCES, SCENARIOS

if TYPE_CHECKING:
    from baselines.evaluation.backends import Backend
    from swarm_forage_env.worlds_on_cpu import Device


def completion_of(names: Collection[str]) -> Callable[[str], list[str]]:
    """Return a function that completes one of these names."""
    return lambda incomplete: [name for name in names if name.startswith(incomplete)]


def scenario_names(incomplete: str) -> list[str]:
    """Return the scenarios and the .toml files of the current folder that begin with this text."""
    return completion_of([*SCENARIOS, *map(str, Path().glob("*.toml"))])(incomplete)


def controller_names(incomplete: str) -> list[str]:
    """Return the controllers, references and kinds of policies that begin with this text."""
    names = [*CONTROLLERS, *REFERENCES, *(f"{kind}:" for kind in POLICIES)]
    return completion_of(names)(incomplete)


ScenarioArgument = Annotated[
    str,
    Argument(
        help="Scenario: a name (see `swarm-forage list`) or a .toml file.",
        autocompletion=scenario_names,
    ),
]

FirstSeedOption = Annotated[
    int, Option(help="Seed of the first episode; the others count up from it.")
]

WorkersOption = Annotated[int, Option(help="Number of worker processes.")]

ThreadsOption = Annotated[int, Option(help="Number of threads for the worlds of a process.")]

SettingsOption = Annotated[
    list[str] | None,
    Option("--set", metavar="NAME=VALUE", help="Set a parameter of the scenario; may be repeated."),
]

EverySettingsOption = Annotated[
    list[str] | None,
    Option(
        "--set", metavar="NAME=VALUE", help="Set a parameter of every scenario; may be repeated."
    ),
]

PhysicsOption = Annotated[
    str | None,
    Option(help="Engine: rigid or kinematic.", show_default="rigid; kinematic for waypoints"),
]


def path(text: str | Path) -> Path:
    """Return the local path of an option; the help shows the name of this function as its type.

    BadParameter for an address such as s3://bucket/x, which would create a folder "s3:".
    """
    if "://" in str(text):  # a default is already a path
        raise typer.BadParameter(
            f"{text}: must be a file or folder on this machine; write it here, then copy it to"
            " the address"
        )
    return Path(text)


FileOption = partial(Option, parser=path)  # option that names a local file or folder to write

DeviceOption = Annotated[
    Literal["cpu", "cuda"],
    Option(help="Device of the worlds: cpu, or cuda for a GPU; the episodes are the same."),
]

BackendOption = Annotated[
    Literal["joblib", "ray"],
    Option("--backend", help="joblib: processes on this machine; ray: processes on a cluster."),
]

AddressOption = Annotated[
    str | None,
    Option(
        "--address",
        metavar="HOST:PORT",
        help="Address of a running Ray cluster; auto: the one on this machine.",
        show_default="a local one, started for this command",
    ),
]


def find_backend(
    name: str, workers: int, threads: int = 1, address: str | None = None, device: "Device" = "cpu"
) -> "Backend":
    """Return the backend of the options; ConfigError if they do not fit or no cluster answers."""
    from baselines.evaluation.evaluate_options import check_count

    cpu_only = ("--backend", name, "joblib"), ("--workers", workers, 1), ("--threads", threads, 1)
    for option, value, usual in cpu_only:
        if device != "cpu" and value != usual:
            other = f"leave it out, or --device={device}"
            raise ConfigError(f"{option}={value}: spreads worlds over CPUs; {other}")
    check_count("--workers", workers)
    check_count("--threads", threads)
    if name == "joblib":
        if address is not None:
            raise ConfigError(f"--address={address}: needs --backend ray")
        from baselines.evaluation.backends import JoblibBackend

        return JoblibBackend(workers, threads, device=device)
    from baselines.evaluation.ray_backend import RayBackend

    backend = RayBackend(workers, threads, address)
    backend.connect()
    return backend
