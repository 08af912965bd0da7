"""The dataset: one Parquet file for each episode, found by configuration and seed.

    OUT/scenario=es1/controller=ssgiff/<configuration>-seed00000003.parquet

The folders are hive partitions: pandas, polars and DuckDB read OUT as one table. A file is
written beside its place and moved there in one step, so that a run killed at any moment leaves
whole files only.
"""

import contextlib
import logging
import os
import socket
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any, get_type_hints
from urllib.parse import quote

import pyarrow as pa
import pyarrow.parquet as pq

from baselines.evaluation.episode import SERIES
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.kinds import AnyEpisode, Kind, kind_of
from swarm_forage_env.errors import ConfigError

LOGGER = logging.getLogger("swarm-forage")

IDENTITY = ("overrides", "parameters", "settings", "code")
"""Columns by which a reader tells configurations apart, beside their key."""

IN_FOLDERS = ("scenario", "controller")
"""Fields of an episode that stand in the names of the folders."""

COLUMN_TYPES = {
    int: pa.int64(),
    float: pa.float64(),
    float | None: pa.float64(),
    str: pa.string(),
    tuple[float, ...]: pa.list_(pa.float64()),
}


def schema(kind: Kind) -> pa.Schema:
    """Columns of a dataset file: the fields of an episode, and what identifies a configuration."""
    types = get_type_hints(kind.episode)
    fields = [
        pa.field(
            name,
            pa.uint64() if name == "seed" else COLUMN_TYPES[each],
            nullable=each == (float | None),
        )
        for name, each in types.items()
        if name not in IN_FOLDERS
    ]
    texts = (pa.field(name, pa.string(), nullable=False) for name in (*IDENTITY, "configuration"))
    return pa.schema([*fields, *texts])


TEMPORARY, DAMAGED = ".tmp", ".damaged"
"""Ends of the names of files that are no episodes; they start with `_`, which readers skip."""

WRITE_RETRIES = 5
"""How often a file is written again whose temporary another run has swept away."""


class DamagedFileError(Exception):
    """A dataset file that is not the episode its name says."""


class Dataset:
    """A folder of kept episodes."""

    def __init__(self, folder: Path) -> None:
        """Name the folder; it may be missing until `open`."""
        self.folder = folder

    def open(self) -> None:
        """Make the folder, check that it is writable, and remove temporary files of killed runs."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            trial = self.folder / _temporary("trial")
            trial.write_bytes(b"")
            trial.unlink(missing_ok=True)
        except OSError as error:
            raise ConfigError(
                f"--out {self.folder}: cannot be written ({error.strerror}); name another folder"
            ) from None
        for leftover in self.folder.rglob(f"_*{TEMPORARY}"):
            leftover.unlink(missing_ok=True)

    def place(self, configuration: ExperimentConfig, seed: int) -> Path:
        """Path of an episode's file, whether it exists or not."""
        folder = self.folder / f"scenario={_quoted(configuration.scenario.name)}"
        folder /= f"controller={_quoted(configuration.recipe.name)}"
        return folder / f"{configuration.key}-seed{seed:08d}.parquet"

    def find(self, configuration: ExperimentConfig, seed: int) -> AnyEpisode | None:
        """Read a kept episode; None if there is none, or a damaged one, which is set aside."""
        file = self.place(configuration, seed)
        try:
            row = _row(file.read_bytes(), configuration, seed)
        except FileNotFoundError:
            return None
        except DamagedFileError as damage:
            aside = file.with_name(f"_{file.name}{DAMAGED}")
            file.replace(aside)
            LOGGER.warning("%s: %s; set aside, the episode is run again", aside, damage)
            return None
        names = configuration.scenario.name, configuration.recipe.name
        return episode_of(row, kind_of(configuration.scenario), *names)

    def keep(self, configuration: ExperimentConfig, episodes: Iterable[AnyEpisode]) -> None:
        """Write each episode atomically to its file."""
        for episode in episodes:
            file = self.place(configuration, episode.seed)
            file.parent.mkdir(parents=True, exist_ok=True)
            columns = schema(kind_of(episode))
            _write(pa.Table.from_pylist([_columns(episode, configuration)], columns), file)


def _columns(episode: AnyEpisode, configuration: ExperimentConfig) -> dict[str, Any]:
    columns = {name: value for name, value in asdict(episode).items() if name not in IN_FOLDERS}
    columns |= {name: getattr(configuration, name) for name in IDENTITY}
    return columns | {"configuration": configuration.key}


def episode_of(row: dict[str, Any], kind: Kind, scenario: str, controller: str) -> AnyEpisode:
    """Make the episode that a row of a dataset file holds."""
    numbers = {name: row[name] for name in kind.episode.__dataclass_fields__ if name in row}
    numbers |= {name: tuple(row[name]) for name in SERIES if name in row}
    episode: AnyEpisode = kind.episode(scenario=scenario, controller=controller, **numbers)
    return episode


def _row(content: bytes, configuration: ExperimentConfig, seed: int) -> dict[str, Any]:
    """The one row in a file's content; DamagedFileError if it is another episode's."""
    try:
        table = pq.read_table(pa.BufferReader(content), page_checksum_verification=True)
    except (pa.ArrowException, OSError, ValueError):
        raise DamagedFileError("not a readable Parquet file") from None
    if not table.schema.equals(schema(kind_of(configuration.scenario))) or table.num_rows != 1:
        raise DamagedFileError("not one row with the columns of an episode")
    row: dict[str, Any] = table.to_pylist()[0]
    if (row["configuration"], row["seed"]) != (configuration.key, seed):
        raise DamagedFileError("the episode of another configuration or seed")
    return row


def _write(table: pa.Table, file: Path) -> None:
    """Write a temporary file to the disk and move it to its place in one step."""
    for attempt in range(WRITE_RETRIES):
        temporary = file.with_name(_temporary(file.name))
        with temporary.open("wb") as stream:
            pq.write_table(table, stream, write_page_checksum=True)
            stream.flush()
            os.fsync(stream.fileno())
        try:
            temporary.replace(file)
            break
        except FileNotFoundError:  # swept by a run that has just started on the same folder
            if attempt == WRITE_RETRIES - 1:
                raise
    fsync_folder(file.parent)


def fsync_folder(folder: Path) -> None:
    """Bring a folder's list of names to the disk, where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _temporary(name: str) -> str:
    return f"_{name}.{quote(socket.gethostname(), safe='')}-{os.getpid()}{TEMPORARY}"


def _quoted(name: str) -> str:
    """A name as readers of hive partitions decode it."""
    return quote(name, safe="")
