"""Everything runs a third task, the folder `patrol`, which no other file here names."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.cli import run
from baselines.evaluation import listing
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import stage_of, task_of
from tests.commands import parallel_env
from tests.outside import OutsideMotion, shown_records
from tests.worlds import check_each_is_itself

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("swarm_forage_env", "baselines", "training")

pytestmark = pytest.mark.usefixtures("patrol")


def test_no_file_of_the_packages_names_it():
    files = [file for package in PACKAGES for file in (ROOT / package).rglob("*.py")]
    assert files
    assert not [file for file in files if "patrol" in file.read_text(encoding="utf-8")]


def test_its_scenario_belongs_to_its_task_and_takes_overrides_and_files(tmp_path):
    scenario = find_scenario("patrol-1", {"task.n_robots": 2, "noise": 0.0})
    assert task_of(scenario).name == "patrol"
    assert (scenario.task.n_robots, scenario.noise) == (2, 0.0)
    file = tmp_path / "mine.toml"
    file.write_text('base = "patrol-1"\n[task]\ndistance = 1.0\n', encoding="utf-8")
    assert find_scenario(file).task.distance == 1.0


def test_its_robots_visit_places_in_turn_in_a_block_and_alone_alike():
    scenario, controller = find_scenario("patrol-1"), find_controller("patrol-ahead")
    block = check_each_is_itself(scenario, controller, [0, 1], ticks=300)
    assert (block.world.robots["visits"] >= 3).all()
    assert block.world.is_over.all()
    assert (block.world.robots["pose"][0] != block.world.robots["pose"][1]).any()


def test_its_motion_driven_from_outside_is_the_motion_inside():
    loop = Loop(find_scenario("patrol-1"), find_controller("patrol-ahead"), [5])
    env = parallel_env("patrol-1", learn="motion")
    observations, infos = env.reset(seed=5)
    assert env.agents == [f"guard_{k}" for k in range(4)]
    assert infos == {agent: {"visits": 0.0, "unshaped_reward": 0.0} for agent in env.agents}
    assert env.state().shape == env.state_space.shape == (9,)
    part = find_controller("patrol-ahead").motion
    steer = OutsideMotion(part.layer(loop.world.scenario), loop.world.scenario, [5])
    total_reward = 0.0
    while env.agents:
        seen = shown_records(env.observation_layout, observations)
        assert_array_equal(seen["situation"], loop.situation)
        wheels = loop.world.state.command.wheels
        commands = steer(seen["situation"], loop.world.robots["readings"][0], wheels)
        actions = dict(zip(env.agents, commands, strict=True))
        observations, rewards, _, truncations, infos = env.step(actions)
        total_reward += sum(rewards.values())
        loop.step()
        assert_array_equal(env.world.robots["pose"], loop.world.robots["pose"])
    assert all(truncations.values())
    assert total_reward == sum(info["visits"] for info in infos.values()) > 0.0


def test_what_it_has_not_is_refused_in_our_words():
    with pytest.raises(UnknownNameError, match="no layer to learn named 'everything'"):
        parallel_env("patrol-1", learn="everything")
    with pytest.raises(ConfigError, match="residual=True: is not available in the task patrol"):
        parallel_env("patrol-1", residual=True)
    with pytest.raises(ConfigError, match="its estimator is not made for the task patrol"):
        parallel_env("patrol-1", controller="ssgikf")
    with pytest.raises(ConfigError, match="its estimator is not made for the task foraging"):
        parallel_env("es1", controller="patrol-ahead")
    with pytest.raises(ConfigError, match="the task patrol has no drawing"):
        stage_of(find_scenario("patrol-1"), "patrol-ahead")


def test_a_shaped_reward_is_shaped_by_its_potential():
    plain, shaped = (parallel_env("patrol-1", shaping=weight) for weight in (0.0, 2.0))
    for env in (plain, shaped):
        env.reset(seed=1)
    ahead = {agent: np.float32([1.0, 1.0]) for agent in plain.agents}
    for _ in range(100):
        rewards, more = plain.step(ahead)[1], shaped.step(ahead)[1]
        visits = plain.world.robots["visits"][0]
        for k, agent in enumerate(ahead):
            before = visits[k] - rewards[agent]
            added = 2.0 * (0.99 * visits[k] - before)
            assert more[agent] == pytest.approx(rewards[agent] + added)


def evaluate(out, *options):
    arguments = "evaluate", "patrol-1", "patrol-ahead", "patrol-ahead:turn=0.5", "--episodes=2"
    return run([*arguments, "--workers=1", f"--out={out}", *options])


def test_the_command_evaluates_it_and_goes_on_from_what_is_kept(capsys, tmp_path):
    assert evaluate(tmp_path, "--format=json") == 0
    episodes = json.loads(capsys.readouterr().out)
    assert all(each["visits_per_robot"] >= 3.0 for each in episodes[:2])
    assert [(each["controller"], each["seed"]) for each in episodes] == [
        ("patrol-ahead", 0), ("patrol-ahead", 1),
        ("patrol-ahead:turn=0.5", 0), ("patrol-ahead:turn=0.5", 1),
    ]  # fmt: skip
    assert evaluate(tmp_path, "--format=json") == 0
    assert json.loads(capsys.readouterr().out) == episodes
    assert evaluate(tmp_path) == 0
    table = capsys.readouterr().out
    assert "patrol-1: 4 robots, 60 s, kinematic" in table
    assert "visits" in table
    assert "Visits per robot against patrol-ahead" in table


def test_the_command_lists_it_with_every_number(capsys):
    names = [each["name"] for each in listing.overview()["scenarios"]]
    assert {"es1", "patrol-1"} <= set(names)
    assert listing.describe("patrol-ahead")["layers"] == {
        "estimator": "patrol_mean", "weighting": "patrol_alone", "motion": "patrol_ahead",
    }  # fmt: skip
    assert list(listing.describe("patrol-1")["parameters"]) == ["patrol-1", "task"]
    assert run(["list", "patrol-1"]) == 0
    assert capsys.readouterr().out.endswith("To set one in evaluate: --set task.n_robots=4\n")
