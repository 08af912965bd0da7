"""A task with the e-puck is one file: everything runs it, and no other file knows of it."""

import importlib
import json
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import swarm_forage_env.aggregation
from baselines.cli import run
from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.world import EpuckWorld, write_numbers
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import field
from swarm_forage_env.registry import SCENARIOS
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from tests.commands import parallel_env
from tests.worlds import check_each_is_itself

HERE = Path(__file__).parent

TASKS = {"aggregation": "gather", "coverage": "sweep"}
"""Each task's scenario, and its hand-written controller."""


@pytest.fixture(scope="module", autouse=True)
def _coverage(registered_here):
    registered_here.syspath_prepend(str(HERE))
    importlib.import_module("coverage_of_floor")
    yield
    del sys.modules["coverage_of_floor"]


@pytest.mark.parametrize(
    "file", [Path(swarm_forage_env.aggregation.__file__), HERE / "coverage_of_floor.py"]
)
def test_such_a_task_is_one_file_of_at_most_150_lines(file):
    assert len(file.read_text(encoding="utf-8").splitlines()) <= 150


def test_a_function_that_no_tick_calls_is_refused_and_so_is_a_task_without_a_score():
    functions = {"brightness_at": 0, "begin_tick": 0, "scor": 0}
    with pytest.raises(ConfigError, match="Own: scor, score unknown or missing; must be bright"):
        type("Own", (EpuckWorld,), {}, robot=0, world=0, functions=functions)


def test_a_task_with_a_radius_of_its_own_and_three_areas_leaves_the_robot_as_it_is():
    class Own(swarm_forage_env.aggregation.AggregationMission):
        radius: float = 0.3

    class Three(swarm_forage_env.aggregation.AggregationScenario):
        task: Own = Own(spot_radius=0.01)
        areas = property(lambda scenario: 0.4 * np.eye(3, 2))

    SCENARIOS.register("three")(Three())
    with pytest.raises(ConfigError, match=r"'three': .* 'custom', the name in it; register it"):
        find_scenario("three")
    world = swarm_forage_env.aggregation.AggregationWorldState.array((1,))
    write_numbers(Three(), world)
    assert world["radius"] == Three().robot.radius
    with pytest.raises(ConfigError, match=r"Own\.radius: a record that it extends has a field of"):
        type("Own", (swarm_forage_env.aggregation.AggregationWorldState,), {"radius": field(float)})


def test_gathered_is_the_share_on_the_fuller_spot():
    spots = np.array([[0, 0, 1, -1], [1, 1, 1, 1], [-1, -1, -1, -1]])
    assert swarm_forage_env.aggregation.gathered(spots).tolist() == [0.5, 1.0, 0.0]


def test_robots_on_one_spot_are_rewarded_by_how_many_they_are():
    loop = Loop(find_scenario("aggregation"), find_controller("gather"), [0], "kinematic")
    robots = loop.world.robots[0]
    robots["pose"][:] = np.c_[np.linspace(-1.0, 1.0, 20), np.full(20, 0.7), np.zeros(20)]
    robots["pose"][:3, :2] = [-0.5, 0.0], [-0.4, 0.1], [0.5, 0.0]
    robots["action"]["motion"] = 1  # a learner that stands
    robots["action"]["wheels"] = 0.0
    loop.step()
    assert robots["spot"].tolist() == [0, 0, 1, *[-1] * 17]
    assert robots["reward"] == pytest.approx([0.01, 0.01, 0.005, *[0.0] * 17])
    assert (robots["readings"]["ground"][:3] == 0.0).all()
    assert (robots["readings"]["ground"][3:] > 0.0).all()


def test_of_robots_that_reach_a_cell_in_one_tick_the_first_is_rewarded_once():
    loop = Loop(find_scenario("coverage"), find_controller("sweep"), [0], "kinematic")
    robots = loop.world.robots[0]
    robots["action"]["motion"] = 1  # a learner that stands
    robots["pose"][:, :2] = np.c_[np.linspace(-0.6, 0.6, 10), np.full(10, 0.3)]
    robots["pose"][:2, :2] = [-0.3825 - 0.036, 0.03], [-0.3825 + 0.036, 0.03]  # one cell
    loop.step()
    assert robots["reward"][:3].tolist() == [1.0, 0.0, 1.0]
    loop.step()
    assert robots["reward"].sum() == 0.0
    loop.reset([1])
    assert (loop.world.worlds["reached"] == -1).all()


@pytest.mark.parametrize("scenario", TASKS)
def test_its_worlds_run_alike_alone_and_in_a_block(scenario):
    controller = find_controller(TASKS[scenario])
    block = check_each_is_itself(find_scenario(scenario), controller, [0, 1], "kinematic")
    assert (block.world.robots["pose"][0] != block.world.robots["pose"][1]).any()


@pytest.mark.parametrize("scenario", TASKS)
def test_its_motion_is_learned_through_every_face(scenario):
    env = parallel_env(scenario, max_cycles=5)
    env.reset(seed=0)
    assert env.state().shape == env.state_space.shape
    while env.agents:
        actions = {agent: env.action_space(agent).sample() for agent in env.agents}
        observations, _, _, _, infos = env.step(actions)
    assert np.isfinite(np.stack(list(observations.values()))).all()
    assert {"messages", "unshaped_reward"} == set(infos["epuck_0"])
    envs = gym.make_vec("swarm_forage_env:SwarmForage/ES1-Joint-v2", num_envs=2, scenario=scenario)
    seen, _ = envs.reset(seed=3)
    assert seen.shape == envs.observation_space.shape
    with pytest.raises(ConfigError, match=f"the task {scenario} has no potential"):
        parallel_env(scenario, shaping=1.0)


@pytest.mark.parametrize("scenario", TASKS)
def test_its_controller_is_better_than_standing_still(scenario):
    world, controller = find_scenario(scenario), find_controller(TASKS[scenario])
    score = task_of(world).episode.score
    seeds = range(5)
    episodes = run_episodes(world, controller, seeds, physics="kinematic")
    stands = Loop(world, controller, seeds, "kinematic")
    stands.world.robots["action"]["motion"] = 1
    stands.run(world.n_ticks)
    meter = task_of(world).episode.meter(stands)
    still = [each[score] for each in meter.results()]
    assert all(getattr(a, score) > b for a, b in zip(episodes, still, strict=True))


@pytest.mark.parametrize("scenario", TASKS)
def test_the_commands_evaluate_and_draw_it(scenario, capsys, tmp_path):
    short, controller = "--set=task.duration=5", TASKS[scenario]
    options = "--episodes=2", "--workers=1", f"--out={tmp_path / 'runs'}", "--format=json"
    command = "evaluate", scenario, controller, short, *options
    assert run([*command, "--physics=rigid", "--trajectories"]) == 0
    episodes = json.loads(capsys.readouterr().out)
    score = task_of(find_scenario(scenario)).episode.score
    assert [each["seed"] for each in episodes] == [0, 1]
    assert all(0.0 <= each[score] <= 1.0 for each in episodes)
    page, picture = tmp_path / "replay.html", tmp_path / "frame.png"
    assert run(["watch", scenario, controller, short, f"--html={page}"]) == 0
    assert run(["watch", scenario, controller, short, f"--frame={picture}"]) == 0
    assert '"believes": false' in page.read_text()
    assert picture.stat().st_size > 1_000
