"""Trajectories of evaluated episodes: one Parquet file each, with a row per robot and tick.

    OUT-trajectories/scenario=es1/controller=ssgiff/<configuration>-seed00000003.trajectory.parquet

Their folder is next to that of the dataset, so that readers can read either folder as one table.
Files are written atomically, with a checksum for every page.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from baselines.evaluation.dataset import DamagedFileError, Dataset, read_table, reading
from baselines.evaluation.experiment_config import ExperimentConfig
from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.global_state import TrajectoryColumn, TrajectoryKind
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import Task, task_of

ENDING = ".trajectory.parquet"  # of file names, by which readers of episodes skip the files
GROUP_ROWS = 200_000  # approximate number of rows, over all worlds, that are buffered

COMPRESSION = {"compression": "zstd", "write_page_checksum": True, "use_dictionary": False}
"""Options of the writer of a file."""

WORDS = pa.dictionary(pa.int16(), pa.string())

EPISODE_COLUMNS = (  # columns of every task, before its own
    TrajectoryColumn("episode", "u8", "seed of the episode: `seed` in the dataset of episodes"),
    TrajectoryColumn("t", "f8", "time since the start [s]; 0: before the first tick"),
    TrajectoryColumn("robot", "i4", "which robot: 0 to N - 1"),
)

CONFIGURATION = "configuration"
"""The last column: the key of the episode's configuration, as in the dataset of episodes."""


def columns_of(kind: TrajectoryKind) -> tuple[TrajectoryColumn, ...]:
    """Return the columns of a file, except `configuration`."""
    return EPISODE_COLUMNS + kind.columns


def trajectory_schema(kind: TrajectoryKind) -> pa.Schema:
    """Return the schema of a file, with the description of each column in its metadata."""
    fields = [
        pa.field(
            each.name,
            WORDS if each.words else pa.from_numpy_dtype(np.dtype(each.kind)),
            nullable=each.is_nullable,
            metadata={"description": each.text},
        )
        for each in columns_of(kind)
    ]
    return pa.schema([*fields, pa.field(CONFIGURATION, WORDS, nullable=False)])


def kind_of(task: Task) -> TrajectoryKind:
    """Return the columns that a task records of its robots; ConfigError if it records none."""
    if task.trajectory is None:
        raise ConfigError(f"--trajectories: the task {task.name} records none")
    return task.trajectory


def trajectory_folder(folder: Path) -> Path:
    """Return the folder of the trajectories of a dataset folder."""
    named = folder if folder.name not in {"", ".."} else folder.resolve()
    return named.with_name(f"{named.name}-trajectories")


class Trajectories(Dataset):
    """Folder of the trajectories of a dataset."""

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(trajectory_folder(dataset.folder), ENDING)

    def holds(self, configuration: ExperimentConfig, seed: int) -> bool:
        """Return whether the whole trajectory is stored; a damaged file is set aside."""
        check = partial(_is_trajectory, configuration, seed)
        return self.read_checked(self.place(configuration, seed), check) is not None


class TrajectoryRecorder:
    """Recorder of the trajectories of a block, compressed in memory until the block ends."""

    def __init__(self, configuration: ExperimentConfig, seeds: Sequence[int]) -> None:
        self._kind = kind_of(task_of(configuration.scenario))
        self._seeds, self._key = tuple(seeds), configuration.key
        self._schema = trajectory_schema(self._kind)
        self._sinks = [pa.BufferOutputStream() for _ in seeds]
        floats = [field.name for field in self._schema if pa.types.is_floating(field.type)]
        encoding = dict.fromkeys(floats, "BYTE_STREAM_SPLIT")  # compresses better
        options = {"column_encoding": encoding, **COMPRESSION}
        self._writers = [pq.ParquetWriter(sink, self._schema, **options) for sink in self._sinks]
        self._ticks: list[dict[str, Array]] = []

    def __call__(self, loop: Loop) -> None:
        """Record one tick of every world."""
        world, shape = loop.world, loop.world.robots.shape
        times = world.worlds["ticks"] * [scenario.tick for scenario in world.scenarios]
        columns = {
            "episode": np.array(self._seeds, np.uint64)[:, None],
            "t": times[:, None],
            "robot": np.arange(world.n_robots),
            **self._kind.take(world, loop.controller.minds),
        }
        kinds = {each.name: each.kind for each in columns_of(self._kind)}
        tick = {name: np.broadcast_to(columns[name], shape).astype(kinds[name]) for name in kinds}
        self._ticks.append(tick)
        if len(self._ticks) * world.robots.size >= GROUP_ROWS:
            self._flush()

    def contents(self) -> dict[int, bytes]:
        """Finish the files of all worlds and return their contents by seed."""
        self._flush()
        for writer in self._writers:
            writer.close()
        sinks = zip(self._seeds, self._sinks, strict=True)
        return {seed: sink.getvalue().to_pybytes() for seed, sink in sinks}

    def _flush(self) -> None:
        """Write the buffered ticks, ordered by tick, then robot."""
        if not self._ticks:
            return
        ticks = {name: np.stack([tick[name] for tick in self._ticks]) for name in self._ticks[0]}
        self._ticks.clear()
        n_ticks, _, n_robots = ticks["robot"].shape
        key = pa.DictionaryArray.from_arrays(np.zeros(n_ticks * n_robots, np.int16), [self._key])
        columns = columns_of(self._kind)
        for world, writer in enumerate(self._writers):
            arrays = [_arrow(ticks[each.name][:, world].reshape(-1), each) for each in columns]
            writer.write_table(pa.Table.from_arrays([*arrays, key], schema=self._schema))


def find_trajectory(sources: Sequence[str], key: str, seed: int) -> Path | None:
    """Find an episode's trajectory file in or next to dataset folders; None without one."""
    name = f"{key}-seed{seed:08d}{ENDING}"
    folders = (folder for own in map(Path, sources) for folder in (trajectory_folder(own), own))
    return next((file for folder in folders for file in folder.rglob(name)), None)


def read_trajectory(file: Path) -> pa.Table:
    """Read the table of a trajectory file and verify its checksums; ConfigError if damaged."""
    with reading(f"trajectory {file}"):
        return read_table(file.read_bytes())


def _arrow(values: Array, column: TrajectoryColumn) -> pa.Array:
    """Return a column as it is written; NaN of nullable columns and negative codes are null."""
    if not column.words:
        return pa.array(values, from_pandas=column.is_nullable)
    codes = pa.array(values.astype(np.int16), mask=values < 0)
    return pa.DictionaryArray.from_arrays(codes, pa.array(column.words, pa.string()))


def _is_trajectory(configuration: ExperimentConfig, seed: int, table: pa.Table) -> bool:
    scenario = configuration.scenario
    if not table.schema.equals(trajectory_schema(kind_of(task_of(scenario)))):
        raise DamagedFileError("not the columns of a trajectory")
    if table.num_rows != (scenario.n_ticks + 1) * scenario.task.n_robots:
        raise DamagedFileError("not a row for each robot and tick")
    ends = {(table[CONFIGURATION][row].as_py(), table["episode"][row].as_py()) for row in (0, -1)}
    if ends != {(configuration.key, seed)}:
        raise DamagedFileError("the trajectory of another configuration or seed")
    return True
