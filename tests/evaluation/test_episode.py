"""An episode: what it holds, and that it does not depend on its company."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pyarrow.parquet as pq
import pytest

from baselines.evaluation.dataset_reader import read_groups
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.tables import report
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.episode import judged_at_the_end
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.episode import WaypointEpisode
from tests.evaluation.conftest import printed, run


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_an_episode_in_a_block_is_the_episode_alone(configure, physics):
    configuration = configure(physics=physics, task_duration=60.0)
    together = run(configuration, [5, 1, 2**64 - 1])
    assert together == [run(configuration, [seed])[0] for seed in (5, 1, 2**64 - 1)]


def test_an_episode_says_what_it_is_of(configuration):
    (episode,) = run(configuration, [7])
    assert (episode.scenario, episode.controller, episode.seed) == ("es1", "ssgikf", 7)
    assert (episode.physics, episode.n_robots, episode.duration_s) == ("kinematic", 10, 20.0)


def test_what_nobody_ever_knew_or_reached_is_missing(configure):
    (episode,) = run(configure(task_duration=1.0), [0])
    assert episode.recruitment_time_s is episode.localisation_error_m is None
    assert episode.round_trips == 0
    assert episode.on_path_over_time == (0.0,) * 10, "a sample a tick"


def test_a_metric_of_a_task_that_is_nan_is_missing():
    meter = judged_at_the_end(lambda world: {"met": np.array([np.nan, 2.0])})(Mock())
    assert meter.results() == [{"met": None}, {"met": 2.0}]


def test_the_series_agree_with_the_numbers_at_the_end(configure):
    """On the path in each hundredth; the last robot recruited is the recruitment time."""
    (episode,) = run(configure(task_duration=600.0), [3])
    path = episode.on_path_over_time
    assert len(path) == 100
    assert path[0] == 0.0
    assert np.mean(path[50:]) == pytest.approx(episode.on_path_share, abs=0.03)
    assert sorted(episode.recruited_at_s) == list(episode.recruited_at_s)
    if len(episode.recruited_at_s) == episode.n_robots:
        assert episode.recruited_at_s[-1] == episode.recruitment_time_s
    else:
        assert episode.recruitment_time_s is None


SHORT = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62, "task.duration": 60.0}


def test_the_sound_robots_are_those_without_a_fault():
    controller, nobody = find_controller("ssgikf"), {"faults.mute.share": 1.0}
    (episode,) = run_episodes(find_scenario("es1", SHORT | nobody), controller, [0], "kinematic")
    assert (episode.sound_robots, episode.round_trips_sound) == (0, None)
    assert episode.on_path_share_sound is episode.localisation_error_sound_m is None
    faults = {"faults.liar.robots": (0, 4), "faults.deaf.robots": (4,)}
    scenario = find_scenario("es1", SHORT | faults)
    loop = Loop(scenario, controller, (0, 1), "kinematic")
    loop.run(600)
    trips = loop.world.robots["round_trips"]
    for w, episode in enumerate(run_episodes(scenario, controller, (0, 1), "kinematic")):
        assert episode.sound_robots == 8
        assert episode.round_trips == trips[w].sum()
        assert episode.round_trips_sound == np.delete(trips[w], [0, 4]).sum()
        assert 0.0 <= episode.on_path_share_sound <= 1.0
    assert trips[:, [0, 4]].any()


def configuration_of(controller="boids-adaptive", scenario="waypoints-10", **task):
    numbers = {f"task.{name}": value for name, value in task.items()}
    chosen = find_scenario(scenario, numbers)
    return ExperimentConfig(controller, chosen, find_layered_controller(controller), "kinematic")


@pytest.fixture
def waypoint_episode():
    """A made-up one."""
    return WaypointEpisode(
        scenario="waypoints-10",
        controller="boids-adaptive",
        seed=3,
        physics="kinematic",
        n_robots=10,
        duration_s=100.0,
        covariance_norm=0.1 + 0.2,
        position_error_m=1 / 3,
        largest_error_m=1.25,
        goals_per_robot=2.1,
        false_goals_per_robot=1.4,
        success_rate=0.6,
        wall_s=1.5,
    )


def test_the_numbers_are_those_of_the_world_and_the_beliefs():
    (episode,) = run(configuration_of(duration=0.5), [0])
    assert episode.success_rate is None, "nobody claimed anything"
    configuration = configuration_of(scenario="waypoints-50-authors")
    scenario = configuration.scenario
    loop = Loop(scenario, configuration.controller, [3, 4], "kinematic")
    norms, errors = [], []
    belief, robots = loop.controller.minds["estimator"]["belief"], loop.world.robots
    for _ in range(scenario.n_ticks):
        loop.step()
        norms.append(np.linalg.norm(belief["P"], 2, axis=(2, 3)))
        off = belief["pose"][:, :, :2] - robots["pose"][:, :, :2]
        errors.append(np.linalg.norm(off, axis=2))
    assert loop.situation.has_arrived.any(), "claims of the last tick count"
    loop.world.judge(loop.situation.has_arrived)
    for world, episode in enumerate(run(configuration, [3, 4])):
        right, wrong = robots["right"][world].sum(), robots["wrong"][world].sum()
        assert episode.goals_per_robot == right / 50
        assert episode.false_goals_per_robot == wrong / 50
        assert episode.success_rate == right / (right + wrong)
        samples = 50 * (200 + 2)
        norm, off = np.array(norms)[:, world], np.array(errors)[:, world]
        assert episode.covariance_norm == pytest.approx(norm.sum() / samples)
        assert episode.position_error_m == pytest.approx(off.sum() / samples)
        assert episode.largest_error_m == pytest.approx(off.max())
    assert robots["right"].sum() > 5


def test_a_dataset_of_before_is_read_in_which_no_error_was_ever_missing(dataset, waypoint_episode):
    kept = replace(waypoint_episode, seed=2**64 - 1, success_rate=None)
    dataset.keep(configuration_of(), [kept])
    (file,) = dataset.folder.rglob("*.parquet")
    table = pq.ParquetFile(file).read()
    number = table.schema.get_field_index("position_error_m")
    before = table.schema.field(number).with_nullable(False)
    pq.write_table(table.set_column(number, before, table.column(number)), file)
    (group,) = read_groups([str(dataset.folder)])
    assert group.episodes == (kept,)


def test_an_episode_of_foraging_in_its_place_is_set_aside(dataset, waypoint_episode, episode):
    configuration = configuration_of()
    dataset.keep(configuration, [episode])
    assert not dataset.find(configuration, [3])
    dataset.keep(configuration, [waypoint_episode])
    assert dataset.find(configuration, [3]) == {3: waypoint_episode}


def test_the_table_shows_means_and_compares_goals(waypoint_episode):
    goals = {"boids-goal": [1.0, 1.2, 1.4, 1.6], "boids-adaptive": [3.0, 3.1, 3.5, 3.6]}
    text = printed(report([
        replace(waypoint_episode, controller=controller, seed=seed, goals_per_robot=count)
        for controller, counts in goals.items()
        for seed, count in enumerate(counts)
    ]))  # fmt: skip
    assert "waypoints-10: 10 robots, 100 s, kinematic physics, seeds 0 to 3" in text
    assert "Goals per robot against boids-goal" in text
    for mean in ("1.3", "3.3", "60.0", "33.3"):  # success in percent, error in centimetres
        assert mean in text
    assert "…" not in text
    assert "nan" not in text.lower()
