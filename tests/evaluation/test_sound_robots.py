"""The metrics of sound robots: beside those of all where robots may be faulty, and nowhere else."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.dataset_reader import read_groups
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.listing import describe, detail_table
from baselines.evaluation.tables import report, to_json
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from tests.evaluation.conftest import printed

SHORT = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62, "task.duration": 60.0}
SOUND = ("sound_robots", "round_trips_sound", "on_path_share_sound", "lost_events_sound")


def episodes(seeds=(0, 1), controller="ssgikf", **faults):
    scenario = find_scenario("es1", SHORT | faults)
    return run_episodes(scenario, find_controller(controller), seeds, "kinematic")


def test_the_sound_robots_are_those_without_a_fault():
    faults = {"faults.liar.robots": (0, 4), "faults.deaf.robots": (4,)}
    found = episodes(**faults)
    scenario = find_scenario("es1", SHORT | faults)
    loop = Loop(scenario, find_controller("ssgikf"), (0, 1), "kinematic")
    for _ in range(600):
        loop.step()
    trips = loop.world.robots["round_trips"]
    for w, episode in enumerate(found):
        assert episode.sound_robots == 8
        assert episode.round_trips == trips[w].sum()
        assert episode.round_trips_sound == np.delete(trips[w], [0, 4]).sum()
        assert 0.0 <= episode.on_path_share_sound <= 1.0
    assert trips[:, [0, 4]].any()


def test_a_swarm_without_sound_robots_has_no_shares_of_them():
    for episode in episodes(**{"faults.mute.share": 1.0}):
        assert (episode.sound_robots, episode.round_trips_sound) == (0, 0)
        assert episode.on_path_share_sound is episode.localisation_error_sound_m is None


def test_tables_tell_of_sound_robots_where_there_are_faults():
    assert "sound" not in printed(report(episodes()))
    found = episodes(**{"faults.liar.share": 0.2})
    assert "sound" in printed(report(found))
    assert json.loads(to_json(found))[0]["round_trips_sound"] == found[0].round_trips_sound


def test_a_dataset_of_before_is_read_and_one_that_lacks_more_is_not(tmp_path):
    scenario = find_scenario("es1", SHORT)
    configuration = ExperimentConfig("nc", scenario, find_controller("nc"), "kinematic")
    Dataset(tmp_path).keep(configuration, episodes((0,), "nc"))
    (file,) = tmp_path.rglob("*.parquet")
    whole = pq.ParquetFile(file).read()
    before = whole.drop_columns([*SOUND, "localisation_error_sound_m"])
    pq.write_table(before, file)
    (group,) = read_groups([str(tmp_path)])
    assert group.episodes[0].round_trips_sound is None
    pq.write_table(before.drop_columns(["messages"]), file)
    with pytest.raises(ConfigError, match="another version"):
        read_groups([str(tmp_path)])


def test_every_fault_is_listed_with_its_fields():
    groups = describe("es1")["parameters"]
    assert "faults" not in groups
    for name in ("dead", "worn", "deaf", "mute", "blind", "liar", "stale"):
        fields = [each["name"] for each in groups[f"faults.{name}"]]
        assert f"faults.{name}.share" in fields
    assert all(each["origin"] for each in groups["faults.liar"])
    assert "faults.liar.conspire" in printed(detail_table("es1"), 160)
