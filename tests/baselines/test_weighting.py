"""SGIKF and SGIFF against values of TR, Eq. 33 to 39, worked by hand."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from baselines.weighting.validation_gate import ValidationGate
from swarm_forage_env.arrays import NEST, PREY
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


@pytest.fixture(scope="session")
def both(exchange, weights):
    """The weights that two robots give each other's nest."""

    def give(rule, own, heard):
        return weights(rule, exchange([own, heard], [heard, own]))[:, NEST].tolist()

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


def test_a_steep_fermi_function_takes_the_better_one_and_does_not_overflow(exchange, weights):
    g = weights(SGIFF(beta=100.0), exchange([1e4, 0.0], [0.0, 1e4]))[:, NEST]
    assert g.tolist() == [1.0, 0.0]


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@given(own=PATHS, heard=PATHS)
def test_the_weight_is_a_share_and_what_i_take_you_keep(both, rule, own, heard):
    mine, yours = both(rule, own, heard)
    assert 0.0 <= mine <= 1.0
    assert mine + yours == pytest.approx(1.0, abs=1e-6)


def merged_p(rule, g, own, heard):
    """p after the exchange, as the estimator computes it."""
    share = rule.layer(find_scenario("es1")).heard_p_share
    return (1.0 - g) * own + share * g * heard


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@given(own=PATHS, heard=PATHS)
def test_both_robots_end_equally_sure(both, rule, own, heard):
    # TR, Eq. 17
    mine, yours = both(rule, own, heard)
    assert merged_p(rule, mine, own, heard) == pytest.approx(
        merged_p(rule, yours, heard, own), abs=1e-4
    )


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_each_robot_and_area_is_weighed_for_itself(exchange, weights, rule):
    together = exchange([1.0, 2.0, 5.0], [3.0, 1.0, 0.5])
    together.own_p[:, PREY], together.heard_p[:, PREY] = (0.5, 4.0, 2.0), (1.5, 2.0, 2.0)
    g = weights(rule, together)
    for row in range(3):
        for area in (NEST, PREY):
            alone = exchange(together.own_p[row, area], together.heard_p[row, area])
            assert g[row, area] == weights(rule, alone)[0, NEST]


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
        (ValidationGate(slack=0.89, drift=0.0), 2.0, 2.0, 0.9, 0.0),
        (ValidationGate(slack=0.91, drift=0.0), 2.0, 2.0, 0.9, 0.5),
        (ValidationGate(slack=0.1, drift=0.21), 2.0, 2.0, 0.9, 0.5),
        (ValidationGate(slack=0.1, drift=0.19), 2.0, 2.0, 0.9, 0.0),
        (ValidationGate(slack=0.25, drift=0.125), 2.0, 2.0, 0.75, 0.5),  # the edge belongs to it
    ],
)
def test_a_gate_lets_in_what_both_paths_explain(exchange, weights, gate, own, heard, apart, g):
    heard_of = exchange(own, heard)
    heard_of.disagreement[:, NEST] = apart
    assert weights(gate, heard_of)[0, NEST] == pytest.approx(g)
