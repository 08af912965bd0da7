"""The example that trains on a GPU, on a CPU: it learns, scores, and keeps a policy."""

import pytest
from numpy.testing import assert_array_equal

pytest.importorskip("stable_baselines3", reason="pip install 'swarm-forage[train]'")

ROLLOUT = 128 * 20 * 10
"""Robot-steps of a rollout of two worlds."""


def test_the_example_trains_and_scores_on_the_exact_engine(example, one_thread, tmp_path, capsys):
    module = example("train_on_gpu")
    options = ["--device=cpu", "--worlds=2", f"--robot-steps={ROLLOUT}", "--intervals=1"]
    (score,) = module.main([*options, "--scored=1", f"--out={tmp_path}"])
    told = capsys.readouterr().out
    assert f"{ROLLOUT:,} robot-steps" in told
    assert f"{score:.1f} round trips" in told
    assert f"swarm-forage evaluate es1 ssgikf sb3:{tmp_path / 'model.zip'}" in told


def test_the_saved_model_is_what_was_learned(example, one_thread, tmp_path):
    from stable_baselines3 import PPO

    module = example("train_on_gpu")
    learner = module.make_learner("cpu", 2, 1.0, seed=0)
    module.save(learner.policy, tmp_path / "model.zip")
    seen = learner.env.reset().numpy()
    wanted, _ = learner.policy.predict(seen, deterministic=True)
    given, _ = PPO.load(tmp_path / "model.zip", device="cpu").predict(seen, deterministic=True)
    assert_array_equal(given, wanted)
