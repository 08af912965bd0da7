"""Where every robot was: kept beside the dataset, whole or run again, read by anybody."""

import logging
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.runner import Plan, check_kept
from baselines.evaluation.trajectories import Trajectories, columns_of, kind_of, trajectory_schema
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import TASKS
from tests.evaluation.conftest import timeless
from tests.evaluation.test_figures import draw

PAGE = Path(__file__).resolve().parents[2] / "docs" / "trajectories.md"


def run(configurations, seeds, dataset, kept=True):
    """Run what is missing: how many episodes that were, and the plan."""
    trajectories = Trajectories(dataset) if kept else None
    if trajectories:
        trajectories.open()
    plan = Plan(configurations, seeds, dataset, trajectories)
    return sum(plan.run(JoblibBackend())), plan


def test_a_row_is_a_robot_as_it_stood_after_a_tick(configure, dataset):
    configuration = configure(task_area_distance=0.7, robot_cruise_speed=0.12)
    run([configuration], range(2), dataset)
    table = pd.read_parquet(f"{dataset.folder}-trajectories")
    own = table[table.episode == 1]
    loop = Loop(configuration.scenario, configuration.controller, [1], "kinematic")
    for tick in range(configuration.scenario.n_ticks + 1):
        if tick:
            loop.step()
        rows = own.iloc[10 * tick : 10 * tick + 10]
        robots = loop.world.robots[0]
        believed = loop.controller.minds["estimator"]["situation"][0]
        assert rows.t.to_numpy() == pytest.approx(0.1 * tick)
        assert rows.robot.tolist() == list(range(10))
        pose = rows[["x", "y", "heading"]].to_numpy()
        np.testing.assert_array_equal(pose, robots["pose"].astype(np.float32))
        goals = [{"nest": 0, "prey": 1}.get(goal, 2) for goal in rows.goal]
        assert goals == believed["goal"].argmax(axis=1).tolist()
        known = rows[["known_nest", "known_prey"]].to_numpy()
        np.testing.assert_array_equal(known, believed["known"] != 0)
        p = rows[["p_nest", "p_prey"]].to_numpy()
        np.testing.assert_array_equal(p, np.where(known, believed["p"], np.nan))
        assert rows.messages.tolist() == robots["heard"]["n"].tolist()
        assert rows.fault.isna().all()
    assert own.messages.sum() > 0
    assert own.known_nest.any()


def test_what_is_kept_is_not_run_again_and_what_is_missing_is(configure, dataset, caplog):
    configuration = configure("nc")
    n_run, plan = run([configuration], range(2), dataset, kept=False)
    bare = timeless(plan.results())
    assert n_run == 2
    n_run, plan = run([configuration], range(3), dataset)
    assert n_run == 3, "two episodes had no trajectory"
    assert timeless(plan.results())[:2] == bare, "a trajectory changes no episode"
    n_run, plan = run([configuration], range(3), dataset)
    assert n_run == 0
    files = [plan.trajectories.place(configuration, seed) for seed in range(3)]
    whole = [file.read_bytes() for file in files]
    at = len(whole[1]) // 2
    files[0].unlink()
    files[1].write_bytes(whole[1][:at] + bytes([whole[1][at] ^ 1]) + whole[1][at + 1 :])
    files[2].write_bytes(whole[1])
    with pytest.raises(OSError, match=rf"-trajectories: 1 of 3 .*{files[0].name}"):
        check_kept(plan)
    with caplog.at_level(logging.WARNING):
        assert run([configuration], range(3), dataset)[0] == 3
    assert [file.read_bytes() for file in files] == whole
    assert len(caplog.messages) == 2, "the flipped bit, and the trajectory of another episode"
    assert "of another configuration or seed" in caplog.text
    assert run([configuration], range(3), dataset)[0] == 0


def test_readers_take_either_folder_for_one_table(configure, dataset):
    run([configure("nc"), configure("ssgiff:beta=0.02")], range(2), dataset)
    assert len(draw("boxplot", str(dataset.folder.parent)).axes) > 0
    table = pd.read_parquet(f"{dataset.folder}-trajectories")
    assert set(table.controller) == {"nc", "ssgiff"}
    assert len(table) == 4 * 201 * 10
    episodes = pd.read_parquet(dataset.folder)[["configuration", "seed", "messages"]]
    assert len(episodes) == 4
    heard = table.groupby(["configuration", "episode"], observed=True).messages.sum()
    for row in episodes.itertuples():
        assert heard[row.configuration, row.seed] == row.messages


def test_paths_read_what_is_kept_and_draw_the_same_map(configure, dataset, caplog):
    caplog.set_level(logging.WARNING)
    run([configure()], range(2), dataset, kept=False)
    anew = draw("paths", str(dataset.folder), seed=1).axes[0].images[0].get_array()
    assert "running" in caplog.text
    run([configure()], range(2), dataset)
    caplog.clear()
    for folder in (dataset.folder, dataset.folder.parent):
        kept = draw("paths", str(folder), seed=1).axes[0].images[0].get_array()
        assert caplog.messages == []
        assert float(np.abs(kept - anew).sum()) <= 0.001 * float(anew.sum())


def test_faults_are_named_while_they_are_in_effect(configure, dataset):
    late = {"faults_mute.share": 1.0, "faults_mute.at": 10.0}
    configuration = configure("nc", **{"faults_deaf.share": 1.0}, **late)
    run([configuration], [0], dataset)
    table = pd.read_parquet(f"{dataset.folder}-trajectories")
    assert set(table[table.t < 9.0].fault) == {"deaf"}
    assert set(table[table.t > 11.0].fault) == {"deaf+mute"}


def test_robots_that_visit_waypoints_are_kept_too(tmp_path):
    asked = EvaluateOptions(
        "waypoints-05-authors", ["boids-goal"], 1, settings=["task.duration=20"]
    )
    plan = asked.plan(tmp_path / "way", trajectories=True)
    assert sum(plan.run(JoblibBackend())) == 1
    table = pd.read_parquet(tmp_path / "way-trajectories")
    assert len(table) == 41 * 5
    away = np.hypot(table.believed_x - table.x, table.believed_y - table.y)
    (episode,) = plan.results()
    assert away.max() == pytest.approx(episode.largest_error_m, rel=1e-4)


def test_a_long_block_is_compressed_in_parts(configure, dataset, monkeypatch):
    monkeypatch.setattr("baselines.evaluation.trajectories.GROUP_ROWS", 1000)
    configuration = configure("nc")
    _, plan = run([configuration], [2], dataset)
    file = pq.ParquetFile(plan.trajectories.place(configuration, 2))
    assert file.num_row_groups == 3, "of 201 ticks of ten robots"


def test_the_page_has_the_columns(configure):
    text = PAGE.read_text()
    for name in ("foraging", "waypoints"):
        kind = kind_of(TASKS[name])
        for column in columns_of(kind):
            kinds = re.search(rf"^\| `{column.name}` \| .*{re.escape(column.text)}", text, re.M)
            assert kinds, column
        described = trajectory_schema(kind).field("x").metadata[b"description"]
        assert described.decode().startswith("true place")
