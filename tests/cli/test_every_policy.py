"""Policies of every layer and form go through the commands as any controller does."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from stable_baselines3 import PPO

import training.controllers  # noqa: F401 the kinds of policies, also where no package is installed
from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controllers
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from tests.beliefs import localisation_error
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

MODULE = """
import numpy as np

def constant(n_numbers):
    return lambda observed: np.full((len(observed), n_numbers), 0.5, np.float32)

n1, n2, n3, n4, n15 = map(constant, (1, 2, 3, 4, 15))

def choice(observed):
    return np.ones(len(observed), np.int64)
"""

BELIEFS = {
    "foraging": ["localisation_error_m"],
    "waypoints": ["covariance_norm", "position_error_m", "largest_error_m"],
}
"""Metrics of what robots believe."""

BELIEVED = {"foraging": "p_nest", "waypoints": "believed_x"}
"""A column of trajectories that holds it."""


def forms(task):
    """The names of policies of all layers, and of some in other forms."""
    own = f"controller={task.controller}"
    (other,) = {"wheels", "pull"} & {*task.steerings}
    plain = {learn: f"n{len(each.action)},learn={learn}" for learn, each in task.policies.items()}
    names = [*plain.values()]
    for learn in ("motion", "everything"):
        names += [f"choice,learn={learn},discrete=true", f"{plain[learn]},action={other},stack=2"]
    return [f"callable:policies:{name},{own}" for name in names]


def refuse(constant):
    raise AssertionError(f"{constant} in JSON")


@pytest.mark.parametrize("name", ["es1", "moving-prey", "waypoints-05", "waypoints-05-authors"])
def test_every_policy_goes_through_every_command(command, tmp_path, name):
    (tmp_path / "policies.py").write_text(MODULE)
    scenario = find_scenario(name)
    task = task_of(scenario)
    policies = forms(task)
    short = f"--set=task.duration={30 * scenario.tick}", "--set=task.n_robots=4"
    run = *short, "--physics=kinematic", "--episodes=1", "--workers=1", "--trajectories"
    status, out, err = command("evaluate", name, *policies, *run, "--out=kept", "--format=json")
    assert status == 0, err
    of_everything = [
        episode
        for episode in json.loads(out, parse_constant=refuse)
        if "learn=everything" in episode["controller"]
    ]
    assert len(of_everything) == 3
    assert {each[metric] for each in of_everything for metric in BELIEFS[task.name]} == {None}
    kept = [pq.read_table(file) for file in (tmp_path / "kept-trajectories").rglob("*.parquet")]
    assert len(kept) == len(policies)
    column = BELIEVED[task.name]
    assert sum(each[column].null_count == len(each) for each in kept) >= len(of_everything)
    drawn = [("boxplot", f"--metric={BELIEFS[task.name][0]}")]
    if task.name == "foraging":
        drawn += [("paths", f"--controller={policies[3]}")]
    for kind, *options in drawn:
        status, _, err = command("plot", kind, "kept", *options, "--out=x.png")
        assert status == 0, err
    for pair in zip(policies[::2], policies[1::2], strict=True):
        status, _, err = command("watch", name, *pair, *short, "--html=x.html")
        assert status == 0, err


def test_in_a_mixed_swarm_errors_are_those_of_the_robots_that_believe_something():
    everything = policy_controller(lambda seen: np.full((len(seen), 15), 0.5), learn="everything")
    scenario = find_scenario("near", {"task.n_robots": 4, "task.duration": 60.0})
    mixture = find_controllers({0: everything, 2: everything, "*": "ssgikf"}, scenario)
    errors = []

    def look(loop):
        if (tick := loop.world.worlds["ticks"][0]) and tick % 10 == 0:
            known = loop.situation.known > 0.0
            assert not known[::2].any()
            errors.extend(localisation_error(loop)[known])

    (episode,) = run_episodes(scenario, mixture, [1], "kinematic", observer=look)
    assert episode.localisation_error_m == pytest.approx(np.mean(errors), rel=1e-6)


@pytest.mark.parametrize("name", ["es1", "waypoints-05"])
def test_robots_without_layers_have_nothing_to_show_them(name):
    everything = policy_controller(lambda seen: np.zeros((len(seen), 15)), learn="everything")
    loop = Loop(find_scenario(name, {"task.n_robots": 4}), everything, [0])
    for part in ("exchange", "situation"):
        with pytest.raises(ConfigError, match="no robot here has an estimator"):
            getattr(loop, part)


SHORT = "--set=task.duration=30", "--episodes=2", "--physics=kinematic", "--workers=1"


@pytest.fixture
def model(tmp_path):
    """The file of an untrained model."""
    env = SwarmVecEnv("es1", n_worlds=1, decision_period=5, physics="kinematic")
    PPO("MlpPolicy", env, seed=0, device="cpu").save(tmp_path / "model.zip")
    return "sb3:model.zip"


def test_the_keywords_of_a_model_are_listed(command, model):
    status, out, _ = command("list", model)
    assert status == 0
    assert "policy.decision_period" in out
    assert "sb3:FILE,name=value" in out
    assert "torchscript:FILE" in command("list")[1]


@pytest.mark.parametrize(
    ("said", "assumed"),
    [("", "residual=0, action=drive, reflexes=true, walk=true, sharpest_turn=0.3, discrete=false,"
          " observation=layer, normalise=true, stack=1, decision_period=10, controller=ssgikf;"),
     (",decision_period=3,action=wheels,controller=ssgiff", "residual=0, action=wheels,"
      " reflexes=false, walk=true, sharpest_turn=0.3, discrete=false, observation=layer,"
      " normalise=true, stack=1, decision_period=3, controller=ssgiff;")],
)  # fmt: skip
def test_what_is_assumed_of_a_model_without_a_card_is_told_once(command, tmp_path, said, assumed):
    env = SwarmVecEnv("es1", n_worlds=1, physics="kinematic")
    made = PPO("MlpPolicy", env, seed=0, device="cpu")
    del made.observation_space.policy_card
    made.save(tmp_path / "bare.zip")
    name = f"sb3:bare.zip{said}"
    status, out, err = command("evaluate", "es1", "nc", name, *SHORT, "--format=json")
    assert status == 0, err
    assert len(json.loads(out)) == 4
    (notice,) = [line for line in err.splitlines() if "card" in line]
    assert f"swarm-forage: policy bare.zip has no card: assuming learn=motion, {assumed}" in notice
