"""Offline transitions: exact for each policy, kept and read whole; cloning, which takes them."""

import re

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal

from baselines.evaluation.experiment_config import ExperimentConfig
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from tests.networks import any_network
from tests.scripts import ROOT
from training import train_command
from training.cloning import Cloner, CloningOptions, discounted_returns, reward_weights
from training.policy_controller import policy_controller
from training.transitions import COLUMNS, DatasetOptions, Recording, card_in, read, world_in

SEED = 7
BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62, "task.duration": 90.0}
SHORT = {"task.duration": 5.0}
TICKS = 50  # of a short episode


@pytest.fixture
def record(tmp_path):
    """A function that runs the command into one folder, which it returns."""
    folder = tmp_path / "runs" / "es1-transitions"

    def run(*arguments, scenario="es1", settings=SHORT):
        changes = [f"--set={name}={value}" for name, value in settings.items()]
        options = [*changes, f"--seed={SEED}", f"--out={folder}"]
        train_command.app(["dataset", scenario, *options, *arguments], standalone_mode=False)
        return folder

    return run


@pytest.fixture
def network(tmp_path):
    """The name of a policy that drives with reflexes, and holds its actions for ten ticks."""
    return any_network(tmp_path, 0)


@pytest.mark.parametrize(
    ("scenario", "policy", "physics", "learners"),
    [
        ("es1", "ssgikf", "kinematic", None),
        ("es1", "learned-both", "rigid", 3),
        ("es1", "random", "kinematic", 3),
        ("es1", "network", "kinematic", 3),
        ("aggregation", "gather", "rigid", 2),
        ("waypoints-05", "boids-goal", "kinematic", 2),
    ],
)
def test_what_was_recorded_is_what_an_environment_shows_and_pays(
    record, network, scenario, policy, physics, learners
):
    name, settings = network if policy == "network" else policy, BUSY if scenario == "es1" else {}
    settings = {"task.duration": 20.0, **settings}
    options = [f"--learners={learners}"] if learners else []
    options += ["--episodes=2", f"--physics={physics}"]
    folder = record(name, *options, scenario=scenario, settings=settings)
    played, card = read(folder, name), card_in(folder, name)
    env = ArrayEnv(
        scenario, 2, DatasetOptions("es1", []).find(name), learners=learners,
        **card.keywords.model_dump(), **world_in(folder, name),
    )  # fmt: skip
    shape = 2, len(env.learners), env.max_cycles
    rows = {key: each.reshape(*shape, *each.shape[1:]) for key, each in played.items()}
    observed, _ = env.reset(seed=[SEED, SEED + 1])
    for tick in range(env.max_cycles):
        assert_array_equal(rows["observation"][:, :, tick], observed)
        observed, rewards, _, truncated, _ = env.step(rows["action"][:, :, tick])
        assert_array_equal(rows["next_observation"][:, :, tick], observed)
        assert_array_equal(rows["reward"][:, :, tick], rewards)
        assert (rows["truncated"][:, :, tick] == truncated[:, None]).all()
    assert set(np.unique(rows["seed"][1])) == {SEED + 1}
    assert_array_equal(rows["robot"][0, :, 0], env.learner_numbers)
    assert not played["terminated"].any()
    assert policy != "learned-both" or played["reward"].any()


def test_a_card_names_the_layers_beside_which_a_clone_plays(record, network):
    folder = record(network, "random", "ssgiff:beta=0.02", "--episodes=1")
    named = {name: card_in(folder, name).controller for name in ("random", "ssgiff:beta=0.02")}
    assert named == {"random": "ssgikf", "ssgiff:beta=0.02": "ssgiff:weighting.beta=0.02"}
    assert card_in(folder, network).controller == "ssgikf"


def test_random_actions_are_uniform(record):
    folder = record("random:action=wheels,reflexes=false,decision_period=1", "--episodes=4")
    actions = read(folder)["action"]
    shares = np.histogram(actions, bins=4, range=(-1.0, 1.0))[0] / actions.size
    assert actions.size == 4 * 10 * TICKS * 2
    assert np.abs(shares - 0.25).max() < 0.03


def test_random_choices_are_refused(record):
    with pytest.raises(ConfigError, match="policy random: draws continuous actions; leave"):
        record("random:discrete=true")


def test_a_run_goes_on_and_a_damaged_file_is_recorded_again(record, capsys):
    command = "ssgikf", "--episodes=3", "--learners=1"
    folder = record(*command)
    before = read(folder)
    _, lost, damaged = sorted(folder.rglob("*.parquet"))
    lost.unlink()
    content = bytearray(damaged.read_bytes())
    content[300] ^= 1
    damaged.write_bytes(content)
    with pytest.raises(ConfigError, match="not a readable Parquet file"):
        read(folder)
    record(*command)
    assert "150 transitions" in (stderr := capsys.readouterr().err)
    assert "2 episodes to play" in stderr
    after = read(folder)
    for name in (*COLUMNS, "policy"):
        assert_array_equal(after[name], before[name])


def test_what_cannot_be_read_as_one_is_refused(record, tmp_path):
    with pytest.raises(ConfigError, match="holds none; record some with"):
        read(tmp_path)
    folder = record("ssgikf", "--episodes=1")
    with pytest.raises(ConfigError, match="holds none of policy 'nc'"):
        read(folder, "nc")
    record("nc", "--episodes=1", settings={"task.duration": 4.0})
    with pytest.raises(ConfigError, match="its files differ in world, observations or actions"):
        read(folder)
    next(folder.glob("*/policy=nc/*")).unlink()
    record("gather", "--episodes=1", scenario="aggregation")
    with pytest.raises(ConfigError, match="its files differ in world, observations or actions"):
        read(folder)
    record("ssgikf", "--episodes=1", "--learners=1", "--seed=8")
    with pytest.raises(ConfigError, match="of 'ssgikf' differ in settings, learners or"):
        read(folder)


def test_a_policy_whose_commands_do_not_repeat_the_episode_is_refused():
    rng = np.random.default_rng(0)
    moody = policy_controller(lambda seen: rng.uniform(-1.0, 1.0, (len(seen), 2)), name="moody")
    scenario = find_scenario("es1", SHORT)
    recording = Recording(ExperimentConfig("moody", scenario, moody, "kinematic"), learners=1)
    with pytest.raises(ConfigError, match="'moody': its commands alone do not repeat"):
        recording.play([SEED])


def test_a_learned_weighting_of_another_trainer_is_refused():
    policy = policy_controller(lambda seen: seen[:, :2], learn="weighting", name="other")
    recording = Recording(ExperimentConfig("other", find_scenario("es1"), policy))
    with pytest.raises(ConfigError, match="replaces weighting, which no card can name"):
        _ = recording.card


@pytest.mark.torchrl
def test_torchrl_takes_the_transitions_as_the_page_says(record, tmp_path, monkeypatch):
    pytest.importorskip("tensordict", reason="run `make test-torchrl`")
    record("ssgikf", "--episodes=1")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "trainers.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```py\n(from tensordict.*?)```", page, re.DOTALL)
    found = {}
    exec(code, found)
    batch = found["transitions"]
    assert batch["action"].shape == (10 * TICKS, 2)
    is_last = batch["next", "done"][:, 0]
    assert is_last.sum() == 10
    assert (batch["next", "observation"][:-1] == batch["observation"][1:])[~is_last[:-1]].all()


def test_a_return_is_what_is_earned_from_a_decision_on_and_then_on_average():
    found = discounted_returns(np.array([[0, 0, 3, 0], [2, 2, 2, 2]], np.float32), 0.5)
    assert found[0].tolist() == [0.84375, 1.6875, 3.375, 0.75]  # 0.75 / (1 - 0.5) follows
    assert found[1].tolist() == [4.0] * 4


def test_an_action_counts_exponentially_by_its_return_and_a_large_one_does_not_overflow():
    weights = reward_weights(np.array([1000.0, 1000.0 + np.log(3.0) / 2.0], np.float32), 0.5)
    assert weights == pytest.approx([0.5, 1.5], abs=1e-3)


@pytest.mark.parametrize(("temperature", "expected"), [(None, 0.0), (0.1, 0.5)])
def test_cloning_does_what_was_done_and_weighted_regression_what_was_paid(temperature, expected):
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    is_paid = rng.random(2_000) < 0.5
    played = {
        "observation": rng.normal(size=(2_000, 3)).astype(np.float32),
        "action": np.where(is_paid, 0.5, -0.5).astype(np.float32)[:, None],
        "reward": is_paid.astype(np.float32),
        "truncated": np.arange(2_000) % 500 == 499,
    }
    cloner = Cloner(played, CloningOptions(temperature, discount=0.0, batch=256))
    for _ in range(200):
        cloner.step()
    actions = cloner.policy.actor(torch.from_numpy(played["observation"])).detach()
    assert actions.mean().item() == pytest.approx(expected, abs=0.1)
