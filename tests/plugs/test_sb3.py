"""The example of stable-baselines3: it trains, keeps its model, and compares it."""

import pytest

pytest.importorskip("stable_baselines3", reason="pip install 'swarm-forage[train]'")

ITERATION = 128 * 80 * 10
"""Robot-steps of a rollout."""


def test_the_example_trains_and_its_model_is_a_controller(example, one_thread, tmp_path, capsys):
    found = example("sb3_ppo").main(
        [f"--robot-steps={2 * ITERATION}", "--episodes=1", f"--out={tmp_path / 'run'}"]
    )
    assert set(found) == {
        "random",
        "ssgikf, hand-written",
        "the trained policy",
        "the same, stochastic",
    }
    assert found["ssgikf, hand-written"] > 100.0
    told = capsys.readouterr().out
    assert f"{2 * ITERATION:,} robot-steps:" in told
    file = tmp_path / "run" / "model.zip"
    assert file.is_file()
    assert f"swarm-forage evaluate es1 ssgikf sb3:{file}" in told
