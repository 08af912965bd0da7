"""What a calibration keeps: the episodes that its results count, and the database of its trials."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import optuna
from sqlalchemy.exc import SQLAlchemyError

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.progress import check_files


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
        check_files(self.folder, list(self.counted))


@contextmanager
def checked_trials(file: Path) -> Iterator[None]:
    """Within it, a database that cannot be read or written is an OSError that names the file."""
    try:
        yield
    except (optuna.exceptions.StorageInternalError, SQLAlchemyError) as error:
        cause = error.__cause__ or error
        why = str(getattr(cause, "orig", None) or cause).splitlines()[0]
        there = "damaged, or on a full disk" if file.is_file() else "not there any more"
        raise OSError(
            f"{file}: {there} ({why}); trials cannot be kept: the same command goes on from those"
            " that are, or begins anew in another folder, named by --out"
        ) from None
