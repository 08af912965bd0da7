"""The examples of stable-baselines3, of cloning and of a graph network train, and compare."""

from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from training import train_command

pytest.importorskip("stable_baselines3", reason="pip install 'swarm-forage[train]'")
torch = pytest.importorskip("torch")

ITERATION = 128 * 80 * 10
"""Robot-steps of a rollout."""


def test_the_example_trains_and_its_model_is_a_controller(example, one_thread, tmp_path, capsys):
    found = example("sb3_ppo").main(
        [f"--robot-steps={2 * ITERATION}", "--episodes=1", f"--out={tmp_path / 'run'}"]
    )
    policies = {"the trained policy", "the same, stochastic"}
    assert set(found) == {"random", "ssgikf, hand-written"} | policies
    assert found["ssgikf, hand-written"] > 100.0
    output = capsys.readouterr().out
    assert f"{2 * ITERATION:,} robot-steps:" in output
    file = tmp_path / "run" / "model.zip"
    assert file.is_file()
    assert f"swarm-forage evaluate es1 ssgikf sb3:{file}" in output


def test_a_clone_is_scored_beside_the_original(example, one_thread, tmp_path, capsys):
    folder, out = tmp_path / "transitions", tmp_path / "clone"
    command = ["dataset", "es1", "ssgikf", "--episodes=1", "--learners=1", f"--out={folder}"]
    assert CliRunner().invoke(train_command.app, command).exit_code == 0
    found = example("behaviour_cloning").main(
        [str(folder), "ssgikf", "--steps=300", "--episodes=1", f"--out={out}"]
    )
    name = f"network:{out}/clone.safetensors,controller=ssgikf"
    assert set(found) == {"ssgikf", name, f"{name},chance=true"}
    assert found["ssgikf"] > 100.0
    assert "round trips an episode: network:" in capsys.readouterr().out


SHORT = {"task.n_robots": 4, "radio.max_range": 0.6, "task.duration": 30.0}


@pytest.fixture
def ppo(example, one_thread, monkeypatch):
    """The example with short rollouts, of robots that speak where their policy wants."""
    found = example("graph_ppo")
    few = partial(found.PPOHyperparameters, n_steps=4, n_epochs=1, n_minibatches=2)
    monkeypatch.setattr(found, "PPOHyperparameters", few)
    monkeypatch.setitem(found.KEYWORDS, "learn", "everything")
    return found


def test_it_learns_what_to_say_and_is_compared_with_others(ppo, capsys):
    options = ppo.Options(robot_steps=1, worlds=2, episodes=1)
    policy = ppo.train(options, **SHORT)
    assert ppo.compare(options, policy, **SHORT).keys() > {"random", "the same, stochastic"}
    output = capsys.readouterr().out
    assert "3,200 robot-steps: reward" in output
    assert "the trained policy:" in output
    assert policy.actor.message[0].weight.grad.abs().sum() > 0.0


def test_a_permutation_of_robots_permutes_their_actions(ppo):
    env = ppo.make_env(ppo.Options(worlds=1), **SHORT)
    network = ppo.GraphNetwork(ppo.Graphs(env), 2, gain=1.0)
    env.reset(seed=3)
    seen = torch.from_numpy(env.step(np.ones((1, 4, 15), np.float32))[0][0])
    senders = [k for k, name in enumerate(env.observation_layout.names) if "sender" in name]
    assert (seen[:, senders] > 0.0).sum() > 2
    order = torch.tensor([2, 0, 3, 1])
    moved = seen[order].clone()
    numbers = torch.cat((torch.zeros(1), (order.argsort() + 1) / 4))
    moved[:, senders] = numbers[(moved[:, senders] * 4).round().long()]
    with torch.no_grad():
        torch.testing.assert_close(network(moved), network(seen)[order])
        deaf = seen.clone()
        deaf[0, senders] = 0.0
        is_changed = (network(deaf) - network(seen)).abs().sum(1) > 1e-6
    assert is_changed.tolist() == [True, False, False, False]
