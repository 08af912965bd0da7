"""The command `train`: what it prints and keeps, and what it refuses."""

import os
import socket

import pytest

from swarm_forage_env.controllers import find_controller
from training.checkpoint import lock_folder

TINY = (
    "--budget=1", "--worlds=1", "--held-back=2", "--population=4", "--workers=1",
    "--physics=kinematic", "--set=task.duration=5",
)  # fmt: skip


def test_training_ends_with_the_policy_and_how_to_test_it(command, tmp_path):
    asked = "train", "weighting", "es1:tick=0.2", "--out=mine", *TINY
    status, stdout, stderr = command(*asked)
    assert status == 0
    assert (tmp_path / "mine" / "best.safetensors").exists()
    assert (tmp_path / "mine" / "best.json").exists()
    score, policy, how = stdout.splitlines()
    assert score == "es1:tick=0.2: 0.0 round trips (0.0 to 0.0) on 2 held-back seeds"
    assert policy == "policy: mine/best.safetensors"
    assert how == (
        "test it: swarm-forage evaluate es1 dsgiff-frequent"
        " learned-weighting:weighting.policy=mine/best.safetensors --seed=1000"
        " --set=task.duration=5 --set=tick=0.2 --physics=kinematic"
    )
    assert "0 of 1 generations found, 1 to run" in stderr
    assert "generation 1: held-back round trips es1:tick=0.2 0.0" in stderr
    again = command(*asked)
    assert again[:2] == (0, stdout)
    assert "1 of 1 generations found, 0 to run" in again[2]


def test_a_second_training_in_one_folder_is_told_who_has_it(command, tmp_path):
    with lock_folder(tmp_path / "x"):
        status, stdout, stderr = command("train", "weighting", "es1", "--out=x", *TINY)
    assert (status, stdout) == (2, "")
    assert f"--out x: process {os.getpid()} on {socket.gethostname()} is training there" in stderr
    assert stderr.count("\n") == 1
    assert command("train", "weighting", "es1", "--out=x", *TINY)[0] == 0


@pytest.mark.parametrize("algorithm", ["cma", "imitation", "ppo"])
@pytest.mark.parametrize("limit", [0, 200, 2000])
def test_training_on_a_full_disk_ends_in_one_line(command, full_disk, algorithm, limit):
    layer = "motion" if algorithm == "ppo" else "weighting"
    tiny = [option for option in TINY if algorithm == "cma" or "population" not in option]
    with full_disk(limit):
        status, stdout, stderr = command(
            "train", layer, "es1", f"--algorithm={algorithm}", "--out=x", *tiny
        )
    assert status in {1, 2}
    assert stdout == ""
    assert "Traceback" not in stderr
    assert "too large" in stderr.splitlines()[-1]


@pytest.mark.parametrize(
    ("layer", "rest", "runs"),
    [
        ("weighting", "ssgiff:pause=10", "learned-weighting"),
        ("weighting", "learned-weighting:pause=10", "learned-weighting"),
        ("weighting", "learned-both", "learned-both"),
        ("motion", "ssgiff:beta=0.001", "learned-motion"),
        ("motion", "learned-weighting", "learned-both"),
        ("motion", "learned-both:motion.policy=motion", "learned-both"),
    ],
)
def test_what_tests_a_policy_runs_it_among_the_layers_it_was_trained_with(
    command, layer, rest, runs
):
    options = f"--controller={rest}", "--out=x", "--algorithm=cma", *TINY
    _, stdout, _ = command("train", layer, "es1", *options)
    _, _, found = stdout.splitlines()[-1].partition("evaluate ")
    scenario, trained_with, how, *_ = found.split()
    assert (scenario, trained_with) == ("es1", rest)
    assert how.partition(":")[0] == runs
    found = find_controller(how).layers
    assert found.pop(layer).policy == "x/best.safetensors"
    assert found.items() <= find_controller(rest).layers.items()


def test_what_no_named_controller_can_test_is_said(command):
    options = "--controller=ssgikf", "--out=x", "--algorithm=cma", *TINY
    _, stdout, _ = command("train", "motion", "es1", *options)
    assert stdout.splitlines()[-1].startswith(
        "test it in Python: training.controllers.with_learned_layers"
    )
