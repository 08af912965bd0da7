"""The options `--backend` and `--address`, which several commands have."""

from typing import TYPE_CHECKING, Annotated, Literal

import typer

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import remedy

if TYPE_CHECKING:
    from baselines.evaluation.backends import Backend


BackendOption = Annotated[
    Literal["joblib", "ray"],
    typer.Option("--backend", help="joblib: processes of this machine. ray: those of a cluster."),
]

AddressOption = Annotated[
    str | None,
    typer.Option(
        "--address",
        metavar="HOST:PORT",
        help="A running Ray cluster; auto: the one of this machine.",
        show_default="a local one, started for this command",
    ),
]


def find_backend(
    name: str, workers: int, threads: int = 1, address: str | None = None
) -> "Backend":
    """The backend of a command's options.

    ConfigError for options that do not fit, or if no cluster answers.
    """
    from baselines.evaluation.evaluate_options import check_count

    check_count("--workers", workers)
    check_count("--threads", threads)
    if name == "joblib":
        if address is not None:
            raise ConfigError(f"--address={address}: is for --backend ray")
        from baselines.evaluation.backends import JoblibBackend

        return JoblibBackend(workers, threads)
    try:
        from baselines.evaluation.ray_backend import RayBackend
    except ModuleNotFoundError as error:
        if error.name != "ray":
            raise
        raise ConfigError(f"--backend=ray: needs the package ray: {remedy('ray')}") from None
    backend = RayBackend(workers, threads, address)
    backend.connect()
    return backend
