"""Datasets at an address that fsspec reads: s3://bucket/x, gs://bucket/x, memory://x.

An object store has no renaming, and needs none: an object appears whole or not at all. An episode
is an object, and a run that was stopped goes on from those that are there.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from baselines.evaluation.dataset import Dataset
from swarm_forage_env.errors import ConfigError


def open_dataset(out: str) -> Dataset:
    """The dataset in a folder of this machine or at an address, ready to be written.

    ConfigError if it cannot be written, or if fsspec does not know such addresses.
    """
    found = RemoteDataset(out) if "://" in out else Dataset(Path(out))
    found.open()
    return found


class RemoteDataset(Dataset):
    """A dataset in an object store; this process writes it, and no worker."""

    shares_files = False

    def __init__(self, address: str) -> None:
        """Name the address. ConfigError if a package is missing that reads such addresses."""
        try:
            from fsspec.core import url_to_fs
        except ModuleNotFoundError:
            raise ConfigError(
                f"--out {address}: needs the package fsspec: pip install fsspec s3fs, or what else"
                " reads such addresses"
            ) from None
        try:
            self._store, path = url_to_fs(address)
        except (ImportError, ValueError) as error:
            raise ConfigError(f"--out {address}: {error}") from None
        super().__init__(Path(path))
        self.address = address

    @property
    def name(self) -> str:
        """The address."""
        return self.address

    def open(self) -> None:
        """Check that objects can be written there."""
        trial = str(self.folder / "_trial")
        try:
            self._store.pipe_file(trial, b"")
            self._store.rm_file(trial)
        except Exception as error:  # each store has errors of its own
            why = " ".join(str(error).split()) or type(error).__name__
            raise ConfigError(
                f"--out {self.address}: cannot be written ({why}); name another address"
            ) from None

    def read(self, file: Path) -> bytes:
        """The content of an episode's object."""
        content: bytes = self._store.cat_file(str(file))
        return content

    def write(self, file: Path, content: bytes) -> None:
        """Put an episode's object."""
        self._store.pipe_file(str(file), content)

    def rename(self, file: Path, new: Path) -> None:
        """Give an object another name."""
        self._store.mv(str(file), str(new))

    def missing(self, files: Sequence[Path]) -> list[Path]:
        """Those of some objects that are not there."""
        self._store.invalidate_cache()
        there: dict[str, Any] = self._store.find(str(self.folder), detail=True)
        names = {name.strip("/") for name in there}
        return [file for file in files if str(file).strip("/") not in names]
