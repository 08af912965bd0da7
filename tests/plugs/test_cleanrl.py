"""The single-file PPO: one seed, one policy; a time-out is no end; the policy is a controller."""

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop

TRAIN = "the single-file PPO needs the extra: pip install 'swarm-forage[train]'"
torch = pytest.importorskip("torch", reason=TRAIN)
pytest.importorskip("tensorboard", reason=TRAIN)

SHORT = {"task.n_robots": 4, "max_cycles": 40}


@pytest.fixture
def ppo(example, one_thread):
    """The example."""
    return example("cleanrl_ppo")


@pytest.fixture
def options(ppo, tmp_path):
    """Two iterations in two worlds, in each of which one episode ends half-way."""

    def make(**more):
        few = {"iterations": 2, "worlds": 2, "steps": 60, "period": 2, "epochs": 2}
        return ppo.Options(**{**few, "out": str(tmp_path / "run"), **more})

    return make


@pytest.fixture
def collected(ppo, options):
    """What untrained robots collect whose every moment is worth two."""

    def collect(**more):
        chosen = options(shaping=0.0, **more)
        env = ppo.make_env(chosen, **SHORT)
        agent = ppo.Agent(len(env.observation_layout), len(env.action_layout))
        torch.nn.init.zeros_(agent.critic[-1].weight)
        torch.nn.init.constant_(agent.critic[-1].bias, 2.0)
        seen, _, trips = ppo.collect(agent, env, ppo.rows_of(env.reset(seed=1)[0]), chosen)
        assert trips == 0.0
        return seen, chosen

    return collect


@pytest.mark.parametrize("learn", ["motion", "weighting", "everything"])
def test_one_seed_one_policy_to_the_last_bit(ppo, options, learn):
    one, other, third = (
        ppo.train(options(learn=learn, seed=seed), **SHORT).state_dict() for seed in (1, 1, 2)
    )
    assert all(torch.equal(one[name], other[name]) for name in one)
    assert not torch.equal(one["policy.0.weight"], third["policy.0.weight"])


def test_the_policy_learns_and_is_kept_with_its_curve(ppo, options, tmp_path):
    before = ppo.train(options(iterations=0), **SHORT).state_dict()
    after = ppo.train(options(), **SHORT).state_dict()
    assert all(torch.isfinite(values).all() for values in after.values())
    assert not any(torch.equal(before[name], after[name]) for name in before)
    assert list((tmp_path / "run").glob("events.out.tfevents.*"))


@pytest.mark.parametrize(
    ("trace", "left"), [(0.0, [1] * 60), (1.0, [*range(40, 0, -1), *range(20, 0, -1)])]
)
def test_a_time_out_is_valued_like_any_other_state_and_advantages_stop_at_it(
    collected, trace, left
):
    seen, chosen = collected(trace=trace)
    expected = 2.0 * (chosen.discount ** torch.tensor(left) - 1.0)
    torch.testing.assert_close(seen.advantages, expected[:, None].expand(-1, 8))


def test_what_it_keeps_does_as_a_controller_what_it_does_in_the_environment(ppo, options):
    chosen = options(iterations=1, worlds=1)
    agent = ppo.train(chosen, **SHORT)
    env = ppo.make_env(chosen, **SHORT)
    observations, _ = env.reset(seed=3)
    for _ in range(20):
        with torch.no_grad():
            action = agent.policy(ppo.rows_of(observations)).clamp(-1.0, 1.0)
        observations, *_ = env.step(action.numpy()[None])
    controller = find_controller(f"torchscript:{chosen.out}/policy.pt")
    loop = Loop(env.world.scenario, controller, [3])
    loop.run(40)
    np.testing.assert_array_equal(loop.world.robots["pose"], env.world.robots["pose"])


def test_the_kept_policy_is_compared_with_others(ppo, monkeypatch, options, capsys):
    monkeypatch.setattr(ppo, "run_episodes", lambda *_: [type("Episode", (), {"round_trips": 3})])
    agent = ppo.train(options(iterations=1))
    assert set(ppo.compare(options(), agent).values()) == {3.0}
    output = capsys.readouterr().out
    assert "ssgikf, hand-written:    3.0 round trips" in output
    assert "the same, stochastic:    3.0 round trips" in output


def test_the_command_line_names_every_option(ppo, monkeypatch):
    found = []
    monkeypatch.setattr(ppo, "train", found.append)
    monkeypatch.setattr(ppo, "compare", lambda options, _: found.append(options))
    ppo.main(["--scenario", "es2", "--learn", "weighting", "--learning-rate", "1e-3"])
    assert found == 2 * [ppo.Options(scenario="es2", learn="weighting", learning_rate=1e-3)]
