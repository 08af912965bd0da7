"""PPO of a graph network: it learns what to say, and whose action is whose."""

from functools import partial

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs the extra: pip install 'swarm-forage[train]'")

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
    told = capsys.readouterr().out
    assert "3,200 robot-steps: reward" in told
    assert "the trained policy:" in told
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
