"""Actors in PyTorch: how their networks begin, and the distribution of an action."""

import numpy as np
import pytest
import torch

from swarm_forage_env.scenarios import find_scenario
from training.actor_critic import ACTORS, CRITICS, LayerPolicy, NamedNetwork
from training.learned_motion import SIZES
from training.policy_file import observation_layout

SHAPES = {
    "first.weight": (2, 3),
    "first.bias": (2,),
    "last.weight": (1, 2),
    "last.bias": (1,),
}


def test_matrices_begin_orthogonal_and_the_last_one_with_its_own_gain():
    arrays = NamedNetwork(SHAPES, "last", 0.01).to_numpy()
    assert {name: array.shape for name, array in arrays.items()} == SHAPES
    first, last = arrays["first.weight"], arrays["last.weight"]
    assert first @ first.T == pytest.approx(2.0 * np.eye(2), abs=1e-5)
    assert np.linalg.norm(last) == pytest.approx(0.01, rel=1e-5)
    assert not arrays["first.bias"].any()
    assert not arrays["last.bias"].any()


def test_arrays_of_a_network_are_copies_and_can_be_set_by_name():
    network = NamedNetwork(SHAPES, "last", 1.0)
    arrays = network.to_numpy()
    arrays["last.bias"][0] = 3.0
    assert network.arrays["last.bias"].item() == 0.0
    network.load_numpy(arrays)
    assert network.arrays["last.bias"].item() == 3.0


def test_an_action_without_effect_hardly_varies_and_depends_on_no_parameter():
    layout = observation_layout("motion", find_scenario("es1"))
    policy = LayerPolicy(layout, ("motion",), -1.5)
    assert policy.log_std.tolist() == [-1.5, -1.5]
    outputs = torch.tensor([[0.5, 0.0]]), torch.tensor([[1.0, 0.0]])  # means, and their effects
    policy.actors["motion"].forward = lambda observed: outputs
    torch.nn.init.zeros_(policy.log_std)
    seen = torch.zeros(1, len(layout))
    gaussian = policy.distribution(seen)
    assert gaussian.mean.tolist() == [[0.5, 0.0]]
    assert gaussian.stddev.tolist()[0] == pytest.approx([1.0, 0.006737947])  # exp(0), exp(-5)
    actions, _, log_probs = policy(seen)
    assert log_probs.tolist() == pytest.approx(gaussian.log_prob(actions).sum(1).tolist())
    gaussian.stddev.sum().backward()
    assert policy.log_std.grad.tolist() == [1.0, 0.0]


@pytest.mark.parametrize("layer", ["weighting", "motion"])
def test_actions_begin_near_zero_and_values_at_the_scale_of_rewards(layer):
    layout = observation_layout(layer, find_scenario("es1"))
    critic = CRITICS[layer](layout).to_numpy()
    assert np.linalg.norm(critic["value.weight"]) == pytest.approx(1.0, rel=1e-5)
    hidden = {"weighting": 32, "motion": SIZES["hidden"]}[layer]
    assert critic["value.weight"].shape == (1, hidden)
    assert len(critic["first.bias"]) == {"weighting": 32, "motion": SIZES["hidden"]}[layer]
    actor = ACTORS[layer](layout).to_numpy()
    if layer == "motion":
        wheels = actor["wheels.weight"]
        assert wheels @ wheels.T == pytest.approx(1e-4 * np.eye(2), abs=1e-9)
    else:
        assert not actor["output.weight"].any()
        assert (np.abs(actor["hidden.weight"]) > 0.0).any()
