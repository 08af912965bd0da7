"""RLlib, new API stack: the example trains; run by `make test-rllib`."""

import math

import pytest

pytestmark = [
    pytest.mark.rllib,
    pytest.mark.filterwarnings("ignore"),  # ray warns about itself
]


@pytest.mark.parametrize("learn", ["motion", "weighting"])
def test_one_policy_trains_on_all_robots(example, small, tmp_path, learn):
    results = example("rllib_ppo").train(
        2, 1, 120, tmp_path / "kept", scenario="es1", learn=learn, max_cycles=60, **small
    )
    assert len(results) == 2
    last = results[-1]
    assert last["env_runners"]["num_env_steps_sampled_lifetime"] == 240
    assert last["env_runners"]["num_module_steps_sampled_lifetime"] == {"robot": 4 * 240}
    assert last["env_runners"]["episode_len_mean"] == 60
    assert last["env_runners"]["num_episodes_lifetime"] == 4
    assert math.isfinite(last["learners"]["robot"]["total_loss"])
    assert last["learners"]["robot"]["mean_kl_loss"] > 0.0
    assert (tmp_path / "kept" / "rllib_checkpoint.json").is_file()
