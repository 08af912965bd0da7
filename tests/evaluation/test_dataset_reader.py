"""Datasets read back: groups with their numbers, and what is no dataset of this version."""

import json
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from baselines.evaluation.dataset_reader import EpisodeGroup, read_groups
from baselines.evaluation.trajectories import read_trajectory
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.task import TASKS


@pytest.fixture
def kept(dataset, configure, episode):
    """nc, and ssgiff under three values of beta; three seeds each."""
    for controller in ("ssgiff:beta=1", "ssgiff:beta=0.001", "ssgiff", "nc"):
        configuration = configure(controller)
        dataset.keep(configuration, [replace(episode, seed=seed) for seed in (2, 0, 1)])
    return dataset


def files(dataset):
    return sorted(dataset.folder.rglob("*.parquet"))


def test_groups_come_back_with_their_numbers_and_episodes_by_seed(kept, episode, monkeypatch):
    alike = replace(FORAGING.episode, episode=type("Alike", (ForagingEpisode,), {}))
    monkeypatch.setitem(TASKS._parts, "a", replace(FORAGING, name="a", episode=alike))
    (kept.folder / "of_the_command_dataset.transitions.parquet").touch()
    groups = read_groups([str(kept.folder)])
    assert [group.label() for group in groups] == [
        "nc", "ssgiff:beta=0.001", "ssgiff", "ssgiff:beta=1",
    ]  # fmt: skip
    assert [each.seed for each in groups[0].episodes] == [0, 1, 2]
    assert groups[0].episodes[0] == replace(episode, seed=0, controller="nc")
    assert groups[1].numbers["weighting.beta"] == 0.001
    assert groups[1].numbers["task.duration"] == 20.0
    assert groups[1].setup() == "es1, task.duration=20, kinematic"
    assert groups[1].setup("task.duration") == "es1, kinematic"
    assert groups[1].label("weighting.beta") == "ssgiff"


def test_a_name_chooses_all_its_parameters_and_a_name_with_parameters_those(
    kept, configure, episode
):
    source, configuration = [str(kept.folder)], configure("ssgiff:beta=1")
    assert len(read_groups(source, controllers=["ssgiff"])) == 3
    assert len(read_groups(source, scenarios=["es1"])) == 4
    (_, read) = read_groups(source, controllers=["nc", "ssgiff:beta=1"])
    episodes = [replace(episode, seed=seed, controller="ssgiff") for seed in range(3)]
    assert read == EpisodeGroup.of(configuration, episodes)
    assert read.configuration().key == configuration.key


def test_an_episode_in_two_datasets_counts_once(kept, new_dataset, configure, episode):
    other = new_dataset("other")
    other.keep(configure("nc"), [replace(episode, seed=seed) for seed in (2, 3)])
    groups = read_groups([str(kept.folder), str(other.folder)], controllers=["nc"])
    assert [each.seed for each in groups[0].episodes] == [0, 1, 2, 3]


def test_a_file_of_two_configurations_is_refused(dataset, configure, episode):
    dataset.keep(configure("nc"), [replace(episode, seed=seed) for seed in (0, 1)])
    (file,) = dataset.folder.rglob("*.parquet")
    one, other = pq.ParquetFile(file).read().to_pylist()
    schema = pq.ParquetFile(file).schema_arrow
    rows = [one, other | {"configuration": "0" * 16}]
    pq.write_table(pa.Table.from_pylist(rows, schema), file)
    with pytest.raises(ConfigError, match="another version"):
        read_groups([str(dataset.folder)])


def names_of(dataset):
    return [group.label() for group in read_groups([str(dataset.folder)])]


def test_episodes_of_one_group_asked_for_by_several_names_have_the_short_one(
    kept, configure, episode
):
    kept.keep(configure("ssgiff:beta=1.0"), [replace(episode, seed=2)])
    kept.keep(configure("ssgiff:beta=0.01"), [replace(episode, seed=2)])
    assert names_of(kept) == ["nc", "ssgiff:beta=0.001", "ssgiff", "ssgiff:beta=1"]


def test_a_dataset_kept_before_names_were_is_read_as_it_was(kept, configure, episode):
    before = names_of(kept)
    kept.keep(configure("ssgiff:beta=0.01"), [replace(episode, seed=seed) for seed in range(3)])
    for file in files(kept):  # which held no name that was asked for
        pq.write_table(pq.ParquetFile(file).read().replace_schema_metadata(None), file)
    assert names_of(kept) == before
    assert kept.find(configure("ssgiff:beta=0.01"), [1])[1].controller == "ssgiff"


def test_two_configurations_asked_for_by_one_name_are_told_apart(dataset, configure, episode):
    """As a policy is, if its file was trained anew on other keywords."""
    for beta in ("0.02", "0.03"):
        made = configure(f"ssgiff:beta={beta}")
        dataset.keep(replace(made, label="sb3:model.zip"), [episode])
    assert names_of(dataset) == ["ssgiff:beta=0.02", "ssgiff:beta=0.03"]


def test_names_and_folders_that_hold_nothing_are_answered_with_what_would_do(kept, tmp_path):
    with pytest.raises(ConfigError, match=r"--controller sgiff: .* controllers nc, ssgiff"):
        read_groups([str(kept.folder)], controllers=["sgiff"])
    with pytest.raises(ConfigError, match=r"--scenario es2: .* scenarios es1"):
        read_groups([str(kept.folder)], scenarios=["es2"])
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "missing", tmp_path / "empty"):
        with pytest.raises(ConfigError, match="swarm-forage evaluate es1 nc ssgikf --out"):
            read_groups([str(folder)])
    (tmp_path / "empty" / "one.transitions.parquet").touch()
    with pytest.raises(ConfigError, match="holds trajectories or transitions, and no episodes"):
        read_groups([str(tmp_path / "empty")])


@pytest.mark.parametrize(
    "read", [lambda file: read_groups([str(file.parents[2])]), read_trajectory]
)
def test_a_file_that_may_not_be_read_is_not_to_be_removed(kept, monkeypatch, read):
    def refuse(file):
        raise PermissionError(13, "Permission denied", str(file))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(ConfigError, match=r"parquet: cannot be read \(Permission denied\)$"):
        read(files(kept)[0])


@pytest.mark.parametrize(
    ("column", "text", "message"),
    [
        ("lost_events", None, "another version .*evaluate again"),
        ("settings", b"\xff\xfe", "not a readable Parquet file; remove it"),
    ],
)
def test_a_file_without_a_column_or_with_what_is_no_text_is_named(kept, column, text, message):
    file = files(kept)[0]
    table = pq.ParquetFile(file).read()
    place = table.schema.get_field_index(column)
    others = table.drop_columns([column])
    if text is not None:
        changed = pa.array([text] * len(table), pa.binary()).view(pa.string())
        others = others.add_column(place, table.schema.field(place), changed)
    pq.write_table(others, file)
    with pytest.raises(ConfigError, match=rf"controller=nc.*parquet: .*{message}"):
        read_groups([str(kept.folder)])


def test_a_dataset_of_before_there_were_faults_is_read(kept):
    file = files(kept)[0]
    whole = pq.ParquetFile(file).read()
    sound = [name for name in whole.column_names if "sound" in name]
    pq.write_table(whole.drop_columns(sound), file)
    assert read_groups([str(kept.folder)])[0].episodes[0].round_trips_sound is None


def test_settings_that_make_no_scenario_are_refused(kept):
    group = read_groups([str(kept.folder)])[0]
    tree = json.loads(group.settings)
    tree["scenario"]["tick"] = "fast"
    with pytest.raises(ConfigError, match=r"settings of nc: tick='fast'"):
        replace(group, settings=json.dumps(tree)).configuration()


def test_episodes_of_two_versions_of_the_code_are_not_mixed(kept, configure, episode, caplog):
    assert read_groups([str(kept.folder)], controllers=["nc", "ssgiff"])
    assert not caplog.text
    for older in (configure("nc"), configure("ssgikf")):
        older.__dict__["code"] = "0123456789abcdef"
        kept.keep(older, [episode])
    assert read_groups([str(kept.folder)], controllers=["ssgikf", "ssgiff"])
    assert "run by another version of swarm-forage than others" in caplog.text
    with pytest.raises(ConfigError, match="several versions of swarm-forage"):
        read_groups([str(kept.folder)])
    assert read_groups([str(kept.folder)], controllers=["ssgiff"])


def test_a_file_outside_of_the_folders_of_names_is_refused(kept):
    stray = kept.folder / "stray.parquet"
    stray.write_bytes(files(kept)[0].read_bytes())
    with pytest.raises(ConfigError, match=r"stray\.parquet: is in no folder named scenario="):
        read_groups([str(kept.folder)])


@pytest.mark.parametrize("policy", ["policy", "beside"])
@pytest.mark.parametrize("asks", [{"trust": True}, {"observation": "layer+os:Class"}])
def test_a_dataset_cannot_say_that_a_file_or_a_module_is_trusted(kept, asks, policy):
    group = read_groups([str(kept.folder)])[0]
    parameters = {
        f"{policy}.{name}": value for name, value in {"file": "model.zip", **asks}.items()
    }
    with pytest.raises(ConfigError, match=r"has a policy with trust=true, 'model.zip', whose code"):
        replace(group, controller="sb3", parameters=json.dumps(parameters)).configuration()


@pytest.mark.parametrize(
    ("controller", "parameters"),
    [
        ("callable", {"policy.file": "os:abort"}),
        ("sb3", {"beside": "CallablePolicy", "beside.file": "os:abort"}),
    ],
)
def test_a_dataset_cannot_name_a_module_to_import(kept, controller, parameters):
    group = read_groups([str(kept.folder)])[0]
    with pytest.raises(ConfigError, match=r"has a policy of a module, 'os:abort', whose code is"):
        replace(group, controller=controller, parameters=json.dumps(parameters)).configuration()
