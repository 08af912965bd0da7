"""The dataset: whole files only, found again, read by others as one table."""

import logging
import re
import sys
from dataclasses import replace
from pathlib import Path

import duckdb
import polars
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from baselines.evaluation.dataset import schema
from baselines.evaluation.dataset_reader import read_groups
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.runner import evaluate
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.episode import FORAGING_EPISODE
from swarm_forage_env.foraging.scenario import Scenario
from tests.scripts import run_python


@pytest.fixture
def file(dataset, configuration, episode):
    """The file of a kept episode."""
    dataset.keep(configuration, [episode])
    return dataset.place(configuration, episode.seed)


def test_an_episode_is_found_as_it_was_kept(dataset, configuration, file, episode):
    assert dataset.find(configuration, [3, 4]) == {3: episode}
    place = f"scenario=es1/controller=ssgikf/{configuration.key}-seed00000003.parquet"
    assert file == dataset.folder / place, "where readers of Hive partitions look"


@pytest.mark.skipif(sys.platform != "linux", reason="counts the threads of Linux")
def test_a_file_is_read_without_threads_which_abort_a_process_that_ends_soon(file):
    code = (
        "import os, sys, pathlib\n"
        "from baselines.evaluation.dataset import read_table\n"
        "content, before = pathlib.Path(sys.argv[1]).read_bytes(), os.listdir('/proc/self/task')\n"
        "print(read_table(content).num_rows, os.listdir('/proc/self/task') == before)"
    )
    assert run_python("-c", code, file) == "1 True"


@pytest.fixture
def together(dataset, configuration, episode):
    """Episodes that were kept together."""
    episodes = [replace(episode, seed=seed, round_trips=seed) for seed in (9, 3, 4, 5)]
    dataset.keep(configuration, episodes)
    return {each.seed: each for each in episodes}


def test_episodes_whose_seeds_follow_each_other_are_a_file_and_found(
    dataset, configuration, together
):
    names = {file.name for file in dataset.folder.rglob("*.parquet")}
    ends = "seed00000003-00000005.parquet", "seed00000009.parquet"
    assert names == {f"{configuration.key}-{end}" for end in ends}
    assert dataset.find(configuration, [9, 2, 5]) == {seed: together[seed] for seed in (9, 5)}
    missing = dataset.missing(configuration, range(2, 7))
    assert missing == [dataset.place(configuration, seed) for seed in (2, 6)]
    assert sorted(pq.read_table(dataset.folder)["seed"].to_pylist()) == [3, 4, 5, 9]
    (group,) = read_groups([str(dataset.folder)])
    assert group.episodes == tuple(together[seed] for seed in (3, 4, 5, 9))


@pytest.mark.parametrize("change", [[4, 3, 5], [3, 3, 5], [3, 4], [3, 4, 6]])
def test_a_file_of_several_with_other_seeds_than_its_name_says_is_set_aside(
    dataset, configuration, together, change
):
    file = dataset.place(configuration, 3, 5)
    rows = pq.ParquetFile(file).read().to_pylist()
    file.write_bytes(written(table_of(*(rows[0] | {"seed": seed} for seed in change))))
    assert dataset.find(configuration, range(10)) == {9: together[9]}
    assert not file.exists()


def test_a_file_of_several_is_named_as_the_controller_is_asked_for_now(dataset, configure, episode):
    episodes = [replace(episode, seed=seed, controller="ssgiff") for seed in range(3)]
    dataset.keep(configure("ssgiff"), episodes)
    asked = configure("ssgiff:beta=0.01")
    found = evaluate([asked], range(1, 3), dataset)
    assert found == [replace(each, controller="ssgiff:beta=0.01") for each in episodes[1:]]
    (group,) = read_groups([str(dataset.folder)])
    assert (group.label(), len(group.episodes)) == ("ssgiff:beta=0.01", 3)


def test_a_name_cannot_lead_out_of_the_folder(dataset, episode):
    controller = find_layered_controller("nc")
    configuration = ExperimentConfig("nc", Scenario(name="../../a=b/ä"), controller)
    dataset.keep(configuration, [episode])
    assert dataset.find(configuration, [3])
    assert pq.read_table(dataset.folder)["scenario"].to_pylist() == ["../../a=b/ä"]
    assert dataset.place(configuration, 3).resolve().is_relative_to(dataset.folder.resolve())


def test_pyarrow_polars_and_duckdb_read_the_folder_as_one_table(dataset, configure, file, episode):
    dataset.keep(configure("ssgiff:beta=0.02"), [replace(episode, seed=9)])
    table = pq.read_table(dataset.folder)
    assert set(table.column_names) == {*schema(FORAGING_EPISODE).names, "scenario", "controller"}
    files = str(dataset.folder / "**/*.parquet")
    for columns in (
        table.sort_by("seed").to_pydict(),
        polars.read_parquet(files, hive_partitioning=True).sort("seed").to_dict(as_series=False),
        duckdb.sql(f"select * from '{files}' order by seed").pl().to_dict(as_series=False),
    ):
        assert columns["controller"] == ["ssgikf", "ssgiff"]
        assert columns["seed"] == [3, 9]
        assert columns["recruitment_time_s"] == [None, None]
        assert columns["parameters"] == ["{}", '{"weighting.beta": 0.02}']
        assert set(columns["overrides"]) == {'{"task.duration": 20.0}'}


def flipped(content, row):
    """One bit of the stored numbers is another."""
    at = content.index(b"kinematic")
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


def renamed(content, row):
    """A letter of the name that the controller was asked for by is another."""
    table = pq.ParquetFile(pa.BufferReader(content)).read()
    asked = table.schema.metadata[b"asked"].replace(b"ssgikf", b"ssgiff")
    return written(table.replace_schema_metadata({b"asked": asked}))


def written(table):
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    return sink.getvalue().to_pybytes()


def table_of(*rows):
    return pa.Table.from_pylist(rows, schema(FORAGING_EPISODE))


DAMAGES = {
    "truncated": lambda content, row: content[: len(content) // 2],
    "empty": lambda content, row: b"",
    "text": lambda content, row: b"seed,round_trips\n3,12\n",
    "flipped": flipped,
    "renamed": renamed,
    "without a column": lambda content, row: written(table_of(row).drop_columns("messages")),
    "two rows": lambda content, row: written(table_of(row, row)),
    "another seed": lambda content, row: written(table_of(row | {"seed": 4})),
    "another key": lambda content, row: written(table_of(row | {"configuration": "0" * 16})),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_file_is_set_aside_with_one_line(
    dataset, configuration, file, damage, caplog, episode
):
    row = pq.read_table(pa.BufferReader(file.read_bytes())).to_pylist()[0]
    file.write_bytes(damage(file.read_bytes(), row))
    with caplog.at_level(logging.WARNING):
        assert not dataset.find(configuration, [3])
    assert not file.exists()
    (damaged_file,) = file.parent.glob("*.damaged")
    (line,) = caplog.messages
    assert re.search(f"{re.escape(str(damaged_file))}.*run again", line)
    assert "\n" not in line
    dataset.keep(configuration, [episode])
    assert dataset.find(configuration, [3]) == {3: episode}
    assert len(pq.read_table(dataset.folder)) == 1, "readers pass over what was set aside"


def test_what_a_killed_run_left_is_ignored_and_swept_and_what_is_of_others_is_let_be(dataset, file):
    leftover = file.with_name(f"_{file.name}.elsewhere-1.tmp")
    leftover.write_bytes(b"PAR1 half of")
    assert len(pq.read_table(dataset.folder)) == 1
    others = [
        dataset.folder / "_theirs.tmp",
        dataset.folder / "_checkpoint.safetensors.elsewhere-1.tmp",
        file.with_name("_notes.elsewhere-1.tmp"),
        dataset.folder / "training" / f"_{file.name}.elsewhere-1.tmp",
    ]
    for each in others:
        each.parent.mkdir(exist_ok=True)
        each.write_bytes(b"theirs")
    blocking = file.with_name(f"_{file.name}.elsewhere-2.tmp")
    blocking.mkdir()
    dataset.open()
    assert not leftover.exists()
    assert all(each.read_bytes() == b"theirs" for each in others)
    assert blocking.is_dir()
    assert file.exists()


@pytest.mark.parametrize("name", ["..", ".", "x" * 300, "ä" * 60])
def test_a_name_that_can_name_no_folder_is_refused(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scenario = tmp_path / "mine.toml"
    scenario.write_text(f'base = "es1"\nname = "{name}"\n')
    with pytest.raises(ConfigError, match=r"cannot name a folder; give it another name"):
        EvaluateOptions(str(scenario), ["nc"], episodes=1).plan(None)
    assert list(tmp_path.iterdir()) == [scenario]


def test_a_file_is_written_again_if_another_run_sweeps_its_temporary(
    dataset, configuration, monkeypatch, episode
):
    replace_file, swept = Path.replace, []

    def sweep_first(self, target):
        if not swept and target.suffix == ".parquet":
            swept.append(self)
            self.unlink()
        return replace_file(self, target)

    monkeypatch.setattr(Path, "replace", sweep_first)
    dataset.keep(configuration, [episode])
    assert swept
    assert dataset.find(configuration, [3]) == {3: episode}
