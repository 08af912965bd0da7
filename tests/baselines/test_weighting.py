"""SGIKF and SGIFF against values of TR, Eq. 33 to 39, worked by hand."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from baselines.weighting.validation_gate import ValidationGate
from swarm_forage_env.arrays import NEST
from swarm_forage_env.compiler import bind
from swarm_forage_env.scenarios import find_scenario

PATHS = st.floats(0.0, 100.0)
RULES = {"sgikf": SGIKF(), "sgiff": SGIFF(), "sgiff, steep": SGIFF(beta=100.0)}


def weigh(exchanges, numbers):
    """The template of a weighting: the free name is its gain."""
    for i in range(exchanges.shape[0]):
        for area in range(2):
            exchanges[i].weight[area] = gain(exchanges[i], area, numbers)


@pytest.fixture(scope="session")
def weights(numbers_of):
    """The weights that a rule gives both areas of every exchange."""

    def give(rule, exchanges):
        layer = rule.layer(find_scenario("es1"))
        bind(weigh, {"gain": layer.gain})(exchanges, numbers_of(layer.all_numbers))
        return exchanges.weight.copy()

    return give


@pytest.mark.parametrize(
    ("own", "heard", "g"), [(1.0, 3.0, 0.25), (3.0, 1.0, 0.75), (2.0, 2.0, 0.5), (0.0, 1.0, 0.0),
                            (1.0, 0.0, 1.0), (0.0, 0.0, 0.5)]
)  # fmt: skip
def test_sgikf_weighs_by_the_share_of_the_own_path(exchange, weights, own, heard, g):
    assert weights(SGIKF(), exchange(own, heard))[0, NEST] == pytest.approx(g)


@pytest.mark.parametrize(
    ("beta", "own", "heard", "g"),
    [
        (0.01, 3.0, 1.0, 1.0 / (1.0 + math.exp(-2.0))),  # 0.01 per cm times 200 cm
        (0.01, 1.0, 3.0, 1.0 / (1.0 + math.exp(2.0))),
        (0.001, 3.0, 1.0, 1.0 / (1.0 + math.exp(-0.2))),
        (100.0, 1e4, 0.0, 1.0),  # a steep one takes the better estimate and does not overflow
        (100.0, 0.0, 1e4, 0.0),
        (0.01, 2.0, 2.0, 0.5),
        (0.01, 0.0, 0.0, 0.5),
        (0.0, 7.0, 1.0, 0.5),
    ],
)
def test_sgiff_is_the_fermi_function_of_the_difference_in_centimetres(
    exchange, weights, beta, own, heard, g
):
    rule = SGIFF(beta=beta)
    assert weights(rule, exchange(own, heard))[0, NEST] == pytest.approx(g, rel=1e-6)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@given(own=PATHS, heard=PATHS)
def test_what_i_take_you_keep_and_both_robots_end_equally_sure(weights, exchange, rule, own, heard):
    # TR, Eq. 17
    mine, yours = weights(rule, exchange([own, heard], [heard, own]))[:, NEST].tolist()
    share = rule.layer(find_scenario("es1")).heard_p_share
    my_p, your_p = (1.0 - mine) * own + share * mine * heard, (1.0 - yours) * heard
    assert mine + yours == pytest.approx(1.0, abs=1e-6)
    assert my_p == pytest.approx(your_p + share * yours * own, abs=1e-4)


@pytest.mark.parametrize(
    ("gate", "own", "heard", "apart", "g"),
    [
        (ValidationGate(), 1.0, 3.0, 0.3, 0.25),  # the gate is 0.2 + 0.05 (1 + 3) = 0.4 wide
        (ValidationGate(), 1.0, 3.0, 0.41, 0.0),
        (ValidationGate(), 3.0, 1.0, 0.39, 0.75),
        (ValidationGate(), 0.0, 0.0, 0.19, 0.5),
        (ValidationGate(), 0.0, 0.0, 0.21, 0.0),
        (ValidationGate(), 40.0, 0.0, 2.1, 1.0),  # an unsure robot believes a stranger
        (ValidationGate(), 1.0, 0.0, 0.3, 0.0),  # a liar that is sure of itself gains nothing
        (ValidationGate(slack=0.91, drift=0.0), 2.0, 2.0, 0.9, 0.5),
        (ValidationGate(slack=0.1, drift=0.19), 2.0, 2.0, 0.9, 0.0),
        (ValidationGate(slack=0.25, drift=0.125), 2.0, 2.0, 0.75, 0.5),  # the edge belongs to it
    ],
)
def test_a_gate_lets_in_what_both_paths_explain(exchange, weights, gate, own, heard, apart, g):
    heard_of = exchange(own, heard)
    heard_of.disagreement[:, NEST] = apart
    assert weights(gate, heard_of)[0, NEST] == pytest.approx(g)
