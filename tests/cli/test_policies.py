"""Policies of other trainers go through the commands as any controller does."""

import json

import pytest
from stable_baselines3 import PPO

from training.vec_env import SwarmVecEnv

SHORT = "--set=task.duration=30", "--episodes=2", "--physics=kinematic", "--workers=1"


@pytest.fixture
def model(tmp_path):
    """The file of an untrained model."""
    env = SwarmVecEnv("es1", n_worlds=1, decision_period=5, physics="kinematic")
    PPO("MlpPolicy", env, seed=0, device="cpu").save(tmp_path / "model.zip")
    return "sb3:model.zip"


def test_a_model_is_evaluated_beside_hand_written_controllers(command, model):
    arguments = ("evaluate", "es1", "nc", model, *SHORT, "--format=json")
    status, out, err = command(*arguments)
    assert status == 0, err
    found = json.loads(out)
    assert [each["controller"] for each in found] == ["nc", "nc", model, model]
    _, again, _ = command(*arguments)
    assert json.loads(again) == found


def test_a_model_is_watched_beside_a_hand_written_controller(command, model, tmp_path):
    told = "watch", "es1", "ssgikf", model, "--seconds=2", "--physics=kinematic"
    assert command(*told, "--html=both.html")[0] == 0
    page = (tmp_path / "both.html").read_text(encoding="utf-8")
    assert "<h1>es1 · ssgikf and sb3:model.zip · seed 0</h1>" in page


def test_a_model_of_waypoints_is_watched(command, tmp_path):
    env = SwarmVecEnv("waypoints-05", n_worlds=1)
    PPO("MlpPolicy", env, seed=0, device="cpu").save(tmp_path / "waypoints.zip")
    named = "watch", "waypoints-05", "sb3:waypoints.zip", "--seconds=5"
    status, _, err = command(*named, "--frame=a.png", "--html=a.html")
    assert status == 0, err


def test_the_keywords_of_a_model_are_listed(command, model):
    status, out, _ = command("list", model)
    assert status == 0
    assert "policy.decision_period" in out
    assert "sb3:FILE,name=value" in out
    assert "torchscript:FILE" in command("list")[1]


def test_a_model_that_does_not_fit_is_refused_before_anything_runs(command, model, tmp_path):
    status, _, err = command("evaluate", "waypoints-05", model)
    assert status != 0
    assert "does not run on 'waypoints-05'" in err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("said", "assumed"),
    [("", "residual=false, action=drive, sharpest_turn=0.3, discrete=false, observation=layer,"
          " normalise=true, stack=1, decision_period=10, controller=ssgikf;"),
     (",decision_period=3,action=wheels,controller=ssgiff", "residual=false, action=wheels,"
      " sharpest_turn=0.3, discrete=false, observation=layer, normalise=true, stack=1,"
      " decision_period=3, controller=ssgiff;")],
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
    (told,) = [line for line in err.splitlines() if "card" in line]
    assert f"swarm-forage: policy bare.zip has no card: assuming learn=motion, {assumed}" in told
