"""The single-file PPO: one seed, one policy; a time-out is no end."""

import pytest

TRAIN = "the single-file PPO needs the extra: pip install 'swarm-forage[train]'"
torch = pytest.importorskip("torch", reason=TRAIN)
safetensors = pytest.importorskip("safetensors.torch", reason=TRAIN)
pytest.importorskip("tensorboard", reason=TRAIN)


@pytest.fixture
def ppo(example, one_thread):
    """The example."""
    return example("cleanrl_ppo")


@pytest.fixture
def options(ppo, tmp_path):
    """Two iterations in two worlds, in each of which one episode ends half-way."""

    def make(learn="motion", **more):
        few = {"iterations": 2, "worlds": 2, "steps": 60, "ticks": 40 * ppo.HOLD[learn]}
        return ppo.Options(**{**few, "learn": learn, "out": str(tmp_path / "run"), **more})

    return make


@pytest.mark.parametrize("learn", ["motion", "weighting", "everything"])
def test_one_seed_one_policy_to_the_last_bit(ppo, options, small, learn):
    one, other, third = (
        ppo.train(options(learn=learn, seed=seed), **small).state_dict() for seed in (1, 1, 2)
    )
    assert all(torch.equal(one[name], other[name]) for name in one)
    assert not torch.equal(one["policy.0.weight"], third["policy.0.weight"])


def test_the_policy_learns_and_is_kept_with_its_curve(ppo, options, small, tmp_path):
    before = ppo.train(options(iterations=0), **small).state_dict()
    after = ppo.train(options(), **small).state_dict()
    assert all(torch.isfinite(values).all() for values in after.values())
    assert not any(torch.equal(before[name], after[name]) for name in before)
    kept = safetensors.load_file(tmp_path / "run" / "policy.safetensors")
    assert all(torch.equal(kept[name], after[name]) for name in after)
    assert list((tmp_path / "run").glob("events.out.tfevents.*"))


def test_a_time_out_is_valued_like_any_other_state(ppo, options, small):
    chosen = options(shaping=0.0, trace=0.0)
    worlds = ppo.Worlds(chosen, **small)
    agent = ppo.Agent(worlds.n_observed, worlds.wheels)
    last = agent.critic[-1]
    torch.nn.init.zeros_(last.weight)
    torch.nn.init.constant_(last.bias, 2.0)
    seen, _ = ppo.collect(agent, worlds, worlds.reset(), chosen)
    assert len(worlds.round_trips) == 1
    torch.testing.assert_close(
        seen.advantages, torch.full((60, worlds.rows), 2.0 * (chosen.discount - 1.0))
    )


def test_advantages_stop_at_the_end_of_an_episode(ppo, options, small):
    chosen = options(shaping=0.0, trace=1.0)
    worlds = ppo.Worlds(chosen, **small)
    agent = ppo.Agent(worlds.n_observed, worlds.wheels)
    last = agent.critic[-1]
    torch.nn.init.zeros_(last.weight)
    torch.nn.init.constant_(last.bias, 2.0)
    seen, _ = ppo.collect(agent, worlds, worlds.reset(), chosen)
    left = torch.tensor([(40 if t < 40 else 60) - t for t in range(60)])
    expected = 2.0 * (chosen.discount**left - 1.0)
    torch.testing.assert_close(seen.advantages, expected[:, None].expand(-1, worlds.rows))


def test_worlds_differ_and_no_episode_comes_twice(ppo, options, small):
    worlds = ppo.Worlds(options(), **small)
    first, second = worlds.reset(), worlds.reset()
    assert len({tuple(row.tolist()) for row in torch.cat([first, second])}) == 2 * worlds.rows


@pytest.mark.parametrize("learn", ["motion", "weighting", "both", "everything"])
def test_an_untrained_policy_drives_forward(ppo, options, small, learn):
    worlds = ppo.Worlds(options(learn=learn), **small)
    agent = ppo.Agent(worlds.n_observed, worlds.wheels)
    n_wheels = 0 if learn == "weighting" else 2
    assert int(worlds.wheels.sum()) == n_wheels
    mean = agent.act(worlds.reset()).mean
    assert ((mean[:, worlds.wheels] - ppo.FORWARD).abs() < 0.1).all()
    assert (mean[:, ~worlds.wheels].abs() < 0.1).all()


def test_the_command_line_names_every_option(ppo, monkeypatch):
    found = []
    monkeypatch.setattr(ppo, "train", found.append)
    ppo.main(["--scenario", "es2", "--learn", "weighting", "--learning-rate", "1e-3"])
    assert found == [ppo.Options(scenario="es2", learn="weighting", learning_rate=1e-3)]
