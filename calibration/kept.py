"""What a calibration keeps: the episodes that its results count, and the database of its trials."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import optuna
from sqlalchemy import make_url
from sqlalchemy.exc import (
    ArgumentError,
    DBAPIError,
    IntegrityError,
    NoSuchModuleError,
    SQLAlchemyError,
)

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.progress import check_files
from swarm_forage_env.errors import ConfigError

PATIENCE = 60.0
"""How long a process waits for another that writes to the same SQLite file [s]."""

ATTEMPTS = 10
"""How often tables are made that another process makes at the same moment."""


class CountedDataset(Dataset):
    """A dataset that knows which episodes were asked of it, and so which must be there."""

    def __init__(self, folder: Path) -> None:
        """Name the folder; it may be missing until `open`."""
        super().__init__(folder)
        self.counted: dict[Path, None] = {}
        """Files of the episodes that were asked for, each once, in that order."""

    def find(self, configuration: ExperimentConfig, seed: int) -> Any | None:  # noqa: ANN401 of its task
        """Read a kept episode; None if there is none, or a damaged one, which is set aside."""
        self.counted[self.place(configuration, seed)] = None
        return super().find(configuration, seed)

    def check(self) -> None:
        """Raise OSError, which names the files, unless all that were asked for are there."""
        check_files(self, list(self.counted))


def trials_address(file: Path, storage: str | None) -> str:
    """The database of trials that was asked for, or else a file; ConfigError if it is no address.

    >>> trials_address(Path("trials.sqlite"), None)
    'sqlite:///trials.sqlite'
    """
    address = f"sqlite:///{file}" if storage is None else storage
    try:
        make_url(address).get_dialect().import_dbapi()
    except (ArgumentError, NoSuchModuleError, ImportError) as error:
        raise ConfigError(
            f"--storage={_shown(address)}: {str(error).splitlines()[0]}; name a database as"
            " sqlite:///FILE or postgresql://USER:PASSWORD@HOST/NAME, whose package is installed"
        ) from None
    return address


def open_trials(address: str) -> optuna.storages.RDBStorage:
    """The database of trials, which is made if it is missing."""
    waits = {"connect_args": {"timeout": PATIENCE}} if address.startswith("sqlite") else {}
    for _ in range(ATTEMPTS):
        try:
            return optuna.storages.RDBStorage(address, engine_kwargs=waits)
        except DBAPIError as error:
            if not (isinstance(error, IntegrityError) or "already exists" in str(error)):
                raise
            time.sleep(0.5)
    return optuna.storages.RDBStorage(address, engine_kwargs=waits)


@contextmanager
def checked_trials(address: str) -> Iterator[None]:
    """Within it, a database that cannot be read or written is an OSError that names it."""
    try:
        yield
    except (optuna.exceptions.StorageInternalError, SQLAlchemyError) as error:
        cause = error.__cause__ or error
        why = str(getattr(cause, "orig", None) or cause).splitlines()[0]
        raise OSError(
            f"{_state(address)} ({why}); trials cannot be kept: the same command goes on from those"
            " that are, or begins anew in another folder, named by --out"
        ) from None


def _state(address: str) -> str:
    """A database that gave an error, and what it suffers from."""
    url = make_url(address)
    if url.get_backend_name() != "sqlite" or not url.database:
        return f"{_shown(address)}: cannot be read or written"
    there = "damaged, or on a full disk" if Path(url.database).is_file() else "not there any more"
    return f"{url.database}: {there}"


def _shown(address: str) -> str:
    """An address without its password."""
    try:
        return make_url(address).render_as_string(hide_password=True)
    except ArgumentError:
        return address
