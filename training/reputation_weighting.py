"""A learned weighting among liars: a network that sees who tells, and who else told the same.

It is a network as that of `training.learned_weighting`, shown also what the estimator
`reputation_odometry` remembers. It is asked about areas that the robot does not know, too.

Not in the papers: all of it; JosangIsmail2002 for the reputations.
"""

import numpy as np
from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import log1p, tanh
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.record import Numbers
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    FEATURES,
    SCALES,
    Features,
    LearnedWeighting,
    WeightingNetwork,
    log_odds,
    scaled_features,
)

REMEMBERED = ("own_known", "own_visited", "right", "wrong", "support", "suspicion", "dissent")
"""Inputs of the network that a robot remembers, for one area of an exchange."""

REMEMBERED_SCALES = ((1.0, 0.35, 0.35), (1.0, 0.35, 0.35), (1.0, 0.7, 0.7), (1.0, 0.7, 0.7),
                     (0.5, 0.7, 0.7), (0.5, 0.7, 0.7), (0.5, 0.7, 0.7))  # fmt: skip
"""Their scaling: unit u, centre c and spread s of (ln(1 + x / u) - c) / s."""


@kernel
def scaled_memory(x: float, feature: int) -> float:
    """Scaled feature (ln(1 + x / u) - c) / s of what is remembered."""
    unit, centre, spread = REMEMBERED_SCALES[feature]
    return (log1p(np.float64(x) / unit) - centre) / spread


@kernel
def remembered_features(exchange: Exchange, area: int) -> Features:
    """Scaled features of what a robot remembers, in the order of `REMEMBERED`."""
    return (
        scaled_memory(exchange.own_known[area], 0),
        scaled_memory(exchange.own_visited[area], 1),
        scaled_memory(exchange.right, 2),
        scaled_memory(exchange.wrong, 3),
        scaled_memory(exchange.support[area], 4),
        scaled_memory(exchange.suspicion[area], 5),
        scaled_memory(exchange.dissent[area], 6),
    )


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """The weight g = 1 / (1 + exp(-l)) of an area, written as a tanh, which cannot overflow."""
    ahead = np.float64(exchange.own_p[area]) - np.float64(exchange.heard_p[area])
    features = scaled_features(exchange, area) + remembered_features(exchange, area)
    return 0.5 + 0.5 * tanh(0.5 * log_odds(features, ahead, numbers.network))


REPUTATION_NETWORK = WeightingNetwork(
    "log-odds-reputation", (*FEATURES, *REMEMBERED), (*SCALES, *REMEMBERED_SCALES), gain
)
"""The network that sees what a robot remembers, too."""


def network_over(estimator: object) -> WeightingNetwork:
    """The architecture of a weighting over an estimator: what it is shown and asked about."""
    remembers = getattr(estimator, "weighs_unknown", False)
    return REPUTATION_NETWORK if remembers else EXCHANGE_NETWORK


@WEIGHTING_RULES.register("learned_reputation")
class LearnedReputation(LearnedWeighting):
    """A trained network sets the weight of a heard estimate by what is remembered of its teller.

        g_i = 1 / (1 + exp(-l))
        p_i = (1 - g_i) p_i + g_i p_j

    Not in the papers: all of it but the form, as in `learned`.
    """

    architecture = REPUTATION_NETWORK

    policy: str = Field(
        "weighting-sceptical",
        description="The network: a bundled policy, or a file as runs/x/best.safetensors",
    )
