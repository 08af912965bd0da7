"""The network of a learned weighting in PyTorch: how it begins, and that it is what runs."""

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose

from baselines.weighting.rows import RowWeighting
from swarm_forage_env.scenarios import find_scenario
from tests.outside import exchanges
from training.dagger import WeightingActor
from training.learned_weighting import EXCHANGE_NETWORK, flatten
from training.policy_file import observation_layout


def test_a_network_begins_near_zero_and_its_hidden_units_orthogonal():
    actor = WeightingActor(observation_layout("weighting", find_scenario("es1")), hidden=4)
    arrays = actor.to_numpy()
    assert {name: array.shape for name, array in arrays.items()} == {
        name: tuple(shape) for name, shape in EXCHANGE_NETWORK.shapes({"hidden": 4}).items()
    }
    first = arrays["hidden.weight"]
    assert first @ first.T == pytest.approx(2.0 * np.eye(4), abs=1e-5)
    assert not arrays["output.weight"].any()
    arrays["output.bias"][...] = 3.0
    assert actor.arrays["output.bias"].item() == 0.0, "arrays are copies"
    actor.load_numpy(arrays)
    assert actor.arrays["output.bias"].item() == 3.0


def test_the_weighting_that_is_trained_is_the_one_that_runs():
    rng = np.random.default_rng(0)
    layout = observation_layout("weighting", find_scenario("es1"))
    n = 50
    path = lambda: rng.uniform(0.0, 9.0, (n, 2))  # noqa: E731 short
    one = rng.uniform(0.02, 1.0, n)
    encounter = exchanges(
        n, own_p=path(), heard_p=path(), disagreement=path(), own_distance=path(),
        heard_distance=path(), range=one, n_averaged=50.0 * one,
    )  # fmt: skip
    torch.manual_seed(0)
    actor = WeightingActor(layout)
    with torch.no_grad():
        for array in actor.parameters():
            array += 0.3 * torch.randn(array.shape)
        given = actor(torch.from_numpy(layout.matrix({"exchange": encounter})))
    numbers = flatten(actor.to_numpy(), EXCHANGE_NETWORK.shapes(actor.sizes))
    assert_allclose(
        given.numpy(), RowWeighting(EXCHANGE_NETWORK.layer(numbers))(encounter), atol=1e-5
    )
