"""Rewards of a weighting: by hand, against the oracle's worlds, and over the blocks of a swarm."""

import numpy as np
import pytest
import torch

from baselines.oracles.oracle import errors
from swarm_forage_env.envs.array_env import ArrayEnv
from training.exchanges import MAX_SQUARED_ERROR, REWARD_UNIT, ErrorRewardVecEnv, error_reduction

TERMS = {"learn": "weighting", "step_on": "exchange", "physics": "kinematic"}


def test_the_reduction_of_the_squared_error_by_hand():
    own = torch.tensor([[0.3, 0.0], [0.3, 0.0], [0.0, 0.1], [2.0, 0.0]])
    heard = torch.tensor([[-0.1, 0.0], [-0.1, 0.0], [0.0, 0.6], [0.0, 0.0]])
    # 0.09 - 0.04; 0.09 - 0.01; 0.01 - 0.1225; a lost robot's error counts half a square metre
    reduced = error_reduction(torch.tensor([0.25, 1.0, 0.5, 1.0]), own, heard)
    torch.testing.assert_close(reduced, torch.tensor([0.05, 0.08, -0.1125, MAX_SQUARED_ERROR]))


@pytest.mark.parametrize("controller", ["ssgikf", "dsgiff-frequent"])
def test_only_the_robot_that_ended_an_exchange_is_paid_and_by_what_it_merged(controller):
    blocks = [ArrayEnv("es1", n_worlds=n, controller=controller, **TERMS) for n in (2, 1)]
    env = ErrorRewardVecEnv(blocks)
    env.seed(3)
    env.reset()
    full, n_paid = torch.ones(env.n_rows, 2), 0
    for _ in range(60):
        acts = env.acts.clone()
        before = [(errors(b.loop.controller.minds, b.world), b.loop.exchange) for b in blocks]
        rewards = env.step(full).rewards
        assert not rewards[~acts].any()
        exact = np.concatenate([by_hand(controller, *each) for each in before])
        np.testing.assert_allclose(rewards, np.where(acts, exact, 0.0), atol=1e-4)
        n_paid += int((rewards != 0.0).sum())
    assert n_paid > 10


def by_hand(controller, erred, exchange):
    """What it earns to take over all that it heard and may merge."""
    own, heard = (np.minimum((each**2).sum(2), MAX_SQUARED_ERROR) for each in erred)
    counts = (exchange.own_known > 0.0) & (exchange.heard_known > 0.0)
    if controller == "ssgikf":
        counts &= exchange.goal[:, :2] > 0.0
    return (counts * (own - heard)).sum(1) / REWARD_UNIT
