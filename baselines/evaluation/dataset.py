"""The dataset: one Parquet file for each episode, found by configuration and seed.

    OUT/scenario=es1/controller=ssgiff/<configuration>-seed00000003.parquet
    OUT/scenario=es1/controller=ssgiff/<configuration>-seed00000004-00009999.parquet

Thousands of episodes with consecutive seeds that end at once share a file, the second one. To
write and to read them one by one would take longer than a GPU takes to run them.

The folders are hive partitions: pyarrow, pandas, polars and DuckDB read OUT as one table. Files
are written atomically, so that a run killed at any moment leaves whole files only. OUT may be an
address that fsspec reads (s3://bucket/x, memory://x): an object, too, appears whole or not at all.
"""

import logging
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar, get_type_hints
from urllib.parse import quote
from zlib import crc32

import pyarrow as pa
import pyarrow.parquet as pq

from baselines.evaluation.episode import AnyEpisode, kind_of_episode
from baselines.evaluation.experiment_config import IDENTITY, ExperimentConfig, short_label
from swarm_forage_env.atomic_write import sweep, temporary_of, write_atomically
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.task import consecutive, task_of

Row = dict[str, Any]
"""An episode as a dataset file holds it: its columns by name."""

CheckedT = TypeVar("CheckedT")

LOGGER = logging.getLogger("swarm-forage")

ASKED = b"asked"
"""Metadata key of the controller's name as the user gave it, after a checksum of the name. It is no
column: `ssgiff` and `ssgiff:beta=0.01` are the same episodes."""

TASK = b"task"
"""Metadata key of the name of the task, whose columns another task may have too."""

IN_FOLDERS = ("scenario", "controller")
"""Fields of an episode that are in the names of the folders."""

COLUMN_TYPES = {
    int: pa.int64(),
    float: pa.float64(),
    float | None: pa.float64(),
    int | None: pa.int64(),
    str: pa.string(),
    tuple[float, ...]: pa.list_(pa.float64()),
}

FILE_STEM = r"[0-9a-f]{16}-seed([0-9]{8,})(?:-([0-9]{8,}))?"
"""Regular expression of the name of a file of episodes, without its ending: first and last seed."""

LONGEST_NAME = 255  # of a file or folder [byte], on the usual file systems
DAMAGED = ".damaged"
"""Ending of files set aside; their names start with `_`, which readers skip."""


def schema(kind: EpisodeKind) -> pa.Schema:
    """Columns of a dataset file: the fields of an episode, and what identifies a configuration."""
    columns = [
        pa.field(
            name,
            pa.uint64() if name == "seed" else COLUMN_TYPES[each],
            nullable=each in (float | None, int | None),
        )
        for name, each in get_type_hints(kind.episode).items()
        if name not in IN_FOLDERS
    ]
    return pa.schema([*columns, *(pa.field(name, pa.string(), False) for name in IDENTITY)])


def folder_name(name: str, prefix: str = "") -> str:
    """The name of a folder: a prefix, and any text as readers of hive partitions decode it.

    ConfigError for a text that names no folder of its own.

    >>> folder_name("a/b", "scenario=")
    'scenario=a%2Fb'
    """
    quoted = prefix + quote(name, safe="")
    if quoted in {"", ".", ".."} or len(quoted) > LONGEST_NAME:
        short_name = name if len(name) < 40 else f"{name[:40]}..."
        raise ConfigError(f"name='{short_name}': cannot name a folder; give it another name")
    return quoted


class DamagedFileError(Exception):
    """Damaged dataset file: it does not hold the episodes that its name states."""


@contextmanager
def reading(subject: str) -> Iterator[None]:
    """Raise ConfigError for a file that cannot be read or has the wrong content."""
    try:
        yield
    except OSError as error:
        raise ConfigError(f"{subject}: cannot be read ({error.strerror})") from None
    except DamagedFileError as damage:
        again = "remove it and run the command that made it again"
        raise ConfigError(f"{subject}: {damage}; {again}") from None


class Dataset:
    """A folder of kept episodes."""

    def __init__(self, folder: Path, ending: str = ".parquet") -> None:
        """Set the folder, which may be missing until `open`, and the ending of its files."""
        self.folder = folder
        self.ending = ending
        self.name = str(folder)
        """Its name in messages."""

    def open(self) -> None:
        """Make the folder, check that it is writable, and remove temporary files of killed runs."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            trial = temporary_of(self.folder / "trial")
            trial.write_bytes(b"")
            trial.unlink(missing_ok=True)
        except OSError as error:
            raise ConfigError(
                f"--out {self.folder}: cannot be written ({error.strerror}); name another folder"
            ) from None
        sweep(self.folder, "trial")
        for folder in self.folder.glob("scenario=*/*=*"):
            sweep(folder, FILE_STEM + re.escape(self.ending))

    def place(self, configuration: ExperimentConfig, seed: int, last: int | None = None) -> Path:
        """Path of an episode's file, whether it exists or not; or of those up to a last seed."""
        folder = self.folder / folder_name(configuration.scenario.name, "scenario=")
        folder /= folder_name(configuration.controller.name, "controller=")
        until = "" if last in (None, seed) else f"-{last:08d}"
        return folder / f"{configuration.key}-seed{seed:08d}{until}{self.ending}"

    def files(self, configuration: ExperimentConfig) -> dict[range, Path]:
        """The files of a configuration by the seeds that they hold, those of most seeds first."""
        name, files = re.compile(FILE_STEM + re.escape(self.ending)), {}
        for file in self.listed(self.place(configuration, 0).parent):
            if file.name.startswith(configuration.key) and (match := name.fullmatch(file.name)):
                files[range(int(match[1]), int(match[2] or match[1]) + 1)] = file
        return dict(sorted(files.items(), key=lambda each: -len(each[0])))

    def find(self, configuration: ExperimentConfig, seeds: Iterable[int]) -> dict[int, AnyEpisode]:
        """Read the stored episodes with these seeds, by seed; damaged files are set aside."""
        kind, wanted = task_of(configuration.scenario).episode, set(seeds)
        episodes: dict[int, AnyEpisode] = {}
        for stored, file in self.files(configuration).items():
            if not wanted.isdisjoint(stored):
                check = partial(_episodes, configuration, kind, stored)
                episodes |= {each.seed: each for each in self.read_checked(file, check) or ()}
        return {seed: episodes[seed] for seed in wanted & episodes.keys()}

    def read_checked(self, file: Path, check: Callable[[pa.Table], CheckedT]) -> CheckedT | None:
        """Return `check` of a file's table; None without a file, or if it raises DamagedFileError.

        A damaged file is renamed so that readers skip it.
        """
        try:
            return check(read_table(self.read(file)))
        except FileNotFoundError:
            return None
        except DamagedFileError as damage:
            damaged_file = file.with_name(f"_{file.name}{DAMAGED}")
            self.rename(file, damaged_file)
            LOGGER.warning("%s: %s; renamed so, and the episode is run again", damaged_file, damage)
            return None

    def keep(self, configuration: ExperimentConfig, episodes: Iterable[AnyEpisode]) -> None:
        """Write episodes atomically, with the controller's name as given.

        Episodes with consecutive seeds are written to one file.
        """
        by_seed, identity = {each.seed: each for each in episodes}, configuration.identity
        for first, end in consecutive([*by_seed]):
            rows = [vars(by_seed[seed]) | identity for seed in range(first, end)]
            table = pa.Table.from_pylist(rows, schema(kind_of_episode(by_seed[first])))
            self._write_named(self.place(configuration, first, end - 1), table, configuration)

    def relabel(self, configuration: ExperimentConfig, file: Path) -> None:
        """Write a file of episodes again, with the controller's name as given."""
        columns = schema(task_of(configuration.scenario).episode)
        self._write_named(file, read_table(self.read(file)).cast(columns), configuration)

    def _write_named(self, file: Path, table: pa.Table, configuration: ExperimentConfig) -> None:
        content = pa.BufferOutputStream()
        names = {ASKED: configuration.label, TASK: task_of(configuration.scenario).name}
        metadata = {key: with_checksum(name) for key, name in names.items()}
        pq.write_table(table.replace_schema_metadata(metadata), content, write_page_checksum=True)
        self.write(file, content.getvalue().to_pybytes())

    def read(self, file: Path) -> bytes:
        """The content of an episode's file. FileNotFoundError if there is none."""
        return file.read_bytes()

    def write(self, file: Path, content: bytes) -> None:
        """Write an episode's file atomically."""
        write_atomically(file, content)

    def rename(self, file: Path, new: Path) -> None:
        """Rename a file, replacing an existing one."""
        file.replace(new)

    def listed(self, folder: Path) -> Iterable[Path]:
        """The files in a folder, as they are now; none if there is no such folder."""
        return (each for each in folder.glob("*") if each.is_file())

    def missing(self, configuration: ExperimentConfig, seeds: Iterable[int]) -> list[Path]:
        """Return the paths of the episodes that are in no file."""
        stored = set(chain.from_iterable(self.files(configuration)))
        return [self.place(configuration, seed) for seed in seeds if seed not in stored]


def _episodes(
    configuration: ExperimentConfig, kind: EpisodeKind, seeds: range, table: pa.Table
) -> list[AnyEpisode]:
    """The episodes in the table of a file that should hold these seeds."""
    if not table.schema.equals(schema(kind)):
        raise DamagedFileError("not the columns of an episode")
    rows = table.to_pylist()
    found = [(row["configuration"], row["seed"]) for row in rows]
    if found != [(configuration.key, seed) for seed in seeds]:
        raise DamagedFileError("episodes of another configuration, or of other seeds")
    usual = short_label(configuration.controller.name, configuration.parameters)
    controller = name_in(table, ASKED) or usual
    return [episode_of(row, kind, configuration.scenario.name, controller) for row in rows]


def episode_of(row: Row, kind: EpisodeKind, scenario: str, controller: str) -> AnyEpisode:
    """Make the episode that a row of a dataset file holds."""
    values = {each.name: row[each.name] for each in fields(kind.episode) if each.name in row}
    values |= {name: tuple(values[name]) for name in kind.series if name in values}
    episode: AnyEpisode = kind.episode(scenario=scenario, controller=controller, **values)
    return episode


def name_in(table: pa.Table, key: bytes) -> str | None:
    """The name under ASKED or TASK, None in a file without it; DamagedFileError if changed."""
    content = (table.schema.metadata or {}).get(key)
    if content is None:
        return None
    text: str = content.partition(b" ")[2].decode(errors="replace")
    if content != with_checksum(text):
        raise DamagedFileError("not a readable Parquet file")
    return text


def with_checksum(text: str) -> bytes:
    """Return a text with a checksum for metadata, which the checksums of pages do not cover."""
    content = text.encode()
    return b"%08x %b" % (crc32(content), content)


def read_table(content: bytes) -> pa.Table:
    """The table in a file's content, its checksums verified; DamagedFileError if it is none."""
    try:
        file = pq.ParquetFile(pa.BufferReader(content), page_checksum_verification=True)
        table = file.read(use_threads=False)  # threads abort a process that ends soon after
        table.validate(full=True)
    except (pa.ArrowException, OSError, ValueError):
        raise DamagedFileError("not a readable Parquet file") from None
    return table


def open_dataset(out: str) -> Dataset:
    """The dataset in a folder or at an address; ConfigError if it cannot be written."""
    dataset = RemoteDataset(out) if "://" in out else Dataset(Path(out))
    dataset.open()
    return dataset


class RemoteDataset(Dataset):
    """A dataset in an object store."""

    def __init__(self, address: str) -> None:
        """Name the address. ConfigError if a package is missing that reads such addresses."""
        try:
            from fsspec.core import url_to_fs
        except ModuleNotFoundError:
            raise ConfigError(
                f"--out {address}: needs the package fsspec: pip install fsspec s3fs, or another"
                " package that reads such addresses"
            ) from None
        try:
            self._store, path = url_to_fs(address)
        except (ImportError, ValueError) as error:
            raise ConfigError(f"--out {address}: {error}") from None
        super().__init__(Path(path))
        self.name = address

    def open(self) -> None:
        """Check that objects can be written there."""
        trial = str(self.folder / "_trial")
        try:
            self._store.pipe_file(trial, b"")
            self._store.rm_file(trial)
        except Exception as error:  # each store has errors of its own
            why = " ".join(str(error).split()) or type(error).__name__
            raise ConfigError(
                f"--out {self.name}: cannot be written ({why}); name another address, or a folder"
            ) from None

    def read(self, file: Path) -> bytes:
        """The content of an episode's object."""
        return bytes(self._store.cat_file(str(file)))

    def write(self, file: Path, content: bytes) -> None:
        """Put an episode's object."""
        self._store.pipe_file(str(file), content)

    def rename(self, file: Path, new: Path) -> None:
        """Give an object another name."""
        self._store.mv(str(file), str(new))

    def listed(self, folder: Path) -> Iterable[Path]:
        """The objects in a folder, as they are now."""
        self._store.invalidate_cache()
        return map(Path, self._store.find(str(folder)))
