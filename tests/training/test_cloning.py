"""Cloning: its equations, and what it learns of actions of which some are paid."""

import numpy as np
import pytest
import torch

from training.cloning import Cloner, CloningOptions, discounted_returns, reward_weights


def test_a_return_is_what_is_earned_from_a_decision_on_and_then_on_average():
    found = discounted_returns(np.array([[0, 0, 3, 0], [2, 2, 2, 2]], np.float32), 0.5)
    assert found[0].tolist() == [0.84375, 1.6875, 3.375, 0.75]  # 0.75 / (1 - 0.5) follows
    assert found[1].tolist() == [4.0] * 4


def test_an_action_counts_exponentially_by_its_return_and_a_large_one_does_not_overflow():
    weights = reward_weights(np.array([1000.0, 1000.0 + np.log(3.0) / 2.0], np.float32), 0.5)
    assert weights == pytest.approx([0.5, 1.5], abs=1e-3)


@pytest.mark.parametrize(("temperature", "expected"), [(None, 0.0), (0.1, 0.5)])
def test_cloning_does_what_was_done_and_weighted_regression_what_was_paid(temperature, expected):
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    is_paid = rng.random(2_000) < 0.5
    played = {
        "observation": rng.normal(size=(2_000, 3)).astype(np.float32),
        "action": np.where(is_paid, 0.5, -0.5).astype(np.float32)[:, None],
        "reward": is_paid.astype(np.float32),
        "truncated": np.arange(2_000) % 500 == 499,
    }
    cloner = Cloner(played, CloningOptions(temperature, discount=0.0, batch=256))
    for _ in range(200):
        cloner.step()
    actions = cloner.policy.actor(torch.from_numpy(played["observation"])).detach()
    assert actions.mean().item() == pytest.approx(expected, abs=0.1)
