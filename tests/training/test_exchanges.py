"""Recorded exchanges by hand, what an error of them counts, and the reward of a weighting by it."""

import numpy as np
import pytest
import torch

from baselines.oracles.oracle import errors
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError
from training.exchanges import (
    BATCH_SIZE,
    MAX_SQUARED_ERROR,
    REWARD_UNIT,
    ErrorRewardVecEnv,
    Exchanges,
    error_reduction,
)


def single(*rows):
    return np.array(rows, np.float32)


def three(n_features=1):
    """Known: 0.3 m wrong and 0.1 m right of it. Unknown: 0.2 m. Known, and told what is worse."""
    return Exchanges(
        np.arange(3.0 * n_features, dtype=np.float32).reshape(3, n_features),
        single((1, 0), (0, 1), (1, 0)),
        single(1, 0, 1),
        single((0.3, 0.0), (9.0, 9.0), (0.0, 0.1)),
        single((-0.1, 0.0), (0.2, 0.0), (0.0, 0.6)),
    )


def trusting(g):
    """An actor with weights g in the rows, of the area that counts; of the other one 7."""
    weights = torch.tensor([[g[0], 7.0], [7.0, g[1]], [g[2], 7.0]])
    return lambda observed: weights[observed[:, 0].long()]


def test_the_loss_of_known_and_of_unknown_areas():
    # (0.75 0.3 - 0.25 0.1)^2; 0.75 0.15 + 0.25 0.04; (0.75 0.1 + 0.25 0.6)^2
    loss = three().loss(torch.tensor([0.25, 0.25, 0.25]))
    np.testing.assert_allclose(loss, [0.04, 0.1225, 0.050625], atol=1e-6)


def test_the_error_and_the_share_of_a_network_are_of_the_area_that_was_told():
    found = three()
    actor = trusting((0.25, 0.25, 0.25))
    assert found.error(actor).item() == pytest.approx((0.04 + 0.1225 + 0.050625) / 3.0)
    # nobody is believed: 0.09, 0.15, 0.01; the oracle: 0.01, 0.04, 0.01
    gain = found.gain("es1")
    assert gain.item() == pytest.approx((0.08 + 0.11) / 3.0)
    share = (0.25 - 0.213125) / 0.19
    assert found.share(actor, gain) == pytest.approx(share, rel=1e-5)
    weights = torch.ones(3, requires_grad=True)
    learning = lambda observed: weights[:, None] * torch.ones(1, 2)  # noqa: E731 short
    assert isinstance(found.share(learning, gain), float)


@pytest.mark.parametrize("rows", [[], [2]])
def test_where_an_oracle_gains_nothing_there_is_nothing_to_learn(rows):
    found = Exchanges(*(each[rows] for each in vars(three()).values()))
    with pytest.raises(ConfigError, match=f"'here': in {len(rows)} exchanges no robot that"):
        found.gain("here")


def test_exchanges_are_joined_row_by_row_and_of_none_all_columns_are_empty():
    nothing = Exchanges.of([], 4)
    assert [each.shape for each in vars(nothing).values()] == [(0, 4), (0, 2), (0,), (0, 2), (0, 2)]
    assert {each.dtype for each in vars(nothing).values()} == {np.dtype(np.float32)}
    both = Exchanges.of([three(4), three(4)], 4)
    assert len(nothing) == 0
    assert len(both) == 6
    for twice, once in zip(vars(both).values(), vars(three(4)).values(), strict=True):
        np.testing.assert_array_equal(twice, np.concatenate([once, once]))


def test_a_batch_is_1024_whole_rows_drawn_by_its_generator():
    found, draws = three(), torch.Generator().manual_seed(0)
    batch = found.draw(draws)
    assert len(batch) == BATCH_SIZE == 1024
    drawn = batch.observed[:, 0].astype(int)
    assert set(drawn.tolist()) == {0, 1, 2}
    for some, every in zip(vars(batch).values(), vars(found).values(), strict=True):
        np.testing.assert_array_equal(some, every[drawn])
    again = found.draw(torch.Generator().manual_seed(0))
    np.testing.assert_array_equal(again.observed, batch.observed)
    assert (found.draw(draws).observed != batch.observed).any()


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
