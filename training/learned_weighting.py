"""Learned confidence weightings: a small network adds to the log-odds of SGIFF.

The reputation network also observes the memory of the estimator `reputation_odometry`: the
reputation of the sender and the agreement of others. It also weighs areas unknown to the robot.

Not in the papers: all of it; JosangIsmail2002 for the reputations.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.estimators.reputation_odometry import ReputationOdometryParameters
from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import log1p, tanh
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Kernel, WeightingLayer
from swarm_forage_env.parameters import BaseScenario, Parameters
from swarm_forage_env.record import Numbers
from training.policy_file import Policy, Shapes, Weights, load_policy, policy_path

FEATURES = ("own_p", "heard_p", "disagreement", "own_p_elsewhere", "own_distance", "heard_distance",
            "frames", "range")  # fmt: skip
"""Inputs of the network for one area of an exchange."""

SCALES = ((0.1, 3.0, 1.5), (0.1, 3.0, 1.5), (0.1, 2.0, 1.5), (0.1, 3.0, 1.5), (0.1, 2.0, 1.0),
          (0.1, 2.0, 1.0), (1.0, 3.5, 1.5), (0.1, 0.75, 0.25))  # fmt: skip
"""Feature scaling: unit u [m, or frames], centre c and spread s of (ln(1 + x / u) - c) / s, which
maps centimetres as well as tens of metres to within a few units of zero."""

REMEMBERED = ("own_known", "own_visited", "right", "wrong", "support", "suspicion", "dissent")
"""Further inputs of the reputation network: what a robot remembers for one area of an exchange."""

REMEMBERED_SCALES = ((1.0, 0.35, 0.35), (1.0, 0.35, 0.35), (1.0, 0.7, 0.7), (1.0, 0.7, 0.7),
                     (0.5, 0.7, 0.7), (0.5, 0.7, 0.7), (0.5, 0.7, 0.7))  # fmt: skip
"""Scaling of `REMEMBERED`: unit u, centre c and spread s of (ln(1 + x / u) - c) / s."""

Features = tuple[float, ...]  # the scaled features of one area of an exchange
HIDDEN = 4  # default number of hidden units


def flatten(weights: Weights, shapes: Shapes) -> Float64[Array, " numbers"]:
    """Flatten the arrays of a network into one vector of weights."""
    return np.concatenate([weights[name].ravel() for name in shapes]).astype(np.float64)


def unflatten(numbers: Array, shapes: Shapes) -> dict[str, Float32[Array, "..."]]:
    """Unflatten a vector of weights into the arrays of a network, in single precision."""
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])
    parts = np.split(np.asarray(numbers, np.float32), ends[:-1])
    arrays = zip(shapes, parts, strict=True)
    return {name: part.reshape(shapes[name]) for name, part in arrays}


@kernel
def scaled(x: float, scale: tuple[float, float, float]) -> float:
    """Return the scaled feature (ln(1 + x / u) - c) / s."""
    unit, centre, spread = scale
    return (log1p(np.float64(x) / unit) - centre) / spread


@kernel
def scaled_features(exchange: Exchange, area: int) -> Features:
    """Return the scaled features of one area of an exchange, in the order of `FEATURES`."""
    return (
        scaled(exchange.own_p[area], SCALES[0]),
        scaled(exchange.heard_p[area], SCALES[1]),
        scaled(exchange.disagreement[area], SCALES[2]),
        scaled(exchange.own_p[1 - area], SCALES[3]),
        scaled(exchange.own_distance[area], SCALES[4]),
        scaled(exchange.heard_distance[area], SCALES[5]),
        scaled(exchange.n_averaged, SCALES[6]),
        scaled(exchange.range, SCALES[7]),
    )


@kernel
def remembered_features(exchange: Exchange, area: int) -> Features:
    """Return the scaled features of a robot's memory, in the order of `REMEMBERED`."""
    return (
        scaled(exchange.own_known[area], REMEMBERED_SCALES[0]),
        scaled(exchange.own_visited[area], REMEMBERED_SCALES[1]),
        scaled(exchange.right, REMEMBERED_SCALES[2]),
        scaled(exchange.wrong, REMEMBERED_SCALES[3]),
        scaled(exchange.support[area], REMEMBERED_SCALES[4]),
        scaled(exchange.suspicion[area], REMEMBERED_SCALES[5]),
        scaled(exchange.dissent[area], REMEMBERED_SCALES[6]),
    )


@kernel
def log_odds(features: Features, ahead: float, network: Float64[Array, " numbers"]) -> float:
    """Return the log-odds of the heard estimate; those of SGIFF if all weights are zero.

        l = (1 + d_0) (p_i - p_j) + d . x + w . tanh(V x + v) + b

    x are the features, `ahead` is p_i - p_j [m], and the flat weights are V, v, w, (d, d_0), b.
    """
    n = len(features)
    hidden = (network.shape[0] - n - 2) // (n + 2)
    biases, outputs, direct = hidden * n, hidden * (n + 1), hidden * (n + 2)
    total = network[direct + n + 1] + (1.0 + network[direct + n]) * ahead
    for k in range(n):
        total += network[direct + k] * features[k]
    for unit in range(hidden):
        activation = network[biases + unit]
        for k in range(n):
            activation += network[unit * n + k] * features[k]
        total += network[outputs + unit] * tanh(activation)
    return float(total)


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return the weight g = 1 / (1 + exp(-l)) of an area, as a tanh, which cannot overflow."""
    ahead = np.float64(exchange.own_p[area]) - np.float64(exchange.heard_p[area])
    odds = log_odds(scaled_features(exchange, area), ahead, numbers.network)
    return 0.5 + 0.5 * tanh(0.5 * odds)


@kernel
def reputation_gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return `gain` of the reputation network."""
    ahead = np.float64(exchange.own_p[area]) - np.float64(exchange.heard_p[area])
    features = scaled_features(exchange, area) + remembered_features(exchange, area)
    return 0.5 + 0.5 * tanh(0.5 * log_odds(features, ahead, numbers.network))


@dataclass(frozen=True)
class WeightingNetwork:
    """Architecture of a learned weighting."""

    name: str  # name on a policy card
    features: tuple[str, ...]  # inputs of the network for one area of an exchange
    scales: tuple[tuple[float, float, float], ...]
    """Unit, centre and spread by which each input is scaled."""
    gain: Kernel  # computes the weight by such a network

    def shapes(self, sizes: Mapping[str, int]) -> Shapes:
        """Return the shapes of the arrays of the network, in the order of the flat weights."""
        hidden, n = sizes["hidden"], len(self.features)
        return {
            "hidden.weight": (hidden, n),
            "hidden.bias": (hidden,),
            "output.weight": (hidden,),
            "direct.weight": (n + 1,),
            "output.bias": (1,),
        }

    def layer(self, numbers: Array, scenario: BaseScenario) -> WeightingLayer:
        """Return the weighting layer of flat weights, which are rounded to single precision."""
        single = np.asarray(numbers, np.float32).astype(np.float64)
        return WeightingLayer(self.gain, {"network": single}, heard_p_share=1.0)

    def numbers_of(self, policy: Policy) -> Float64[Array, " numbers"]:
        """Return the flat weights of a policy's weighting. ConfigError if it does not fit."""
        policy.check_fits("weighting", Scenario())
        shapes = self.shapes(policy.sizes_of("weighting", self.name, ("hidden",)))
        return flatten(policy.weights_of("weighting", shapes), shapes)


EXCHANGE_NETWORK = WeightingNetwork("log-odds", FEATURES, SCALES, gain)
"""Network on what a learner of the weighting observes."""


REPUTATION_NETWORK = WeightingNetwork(
    "log-odds-reputation", (*FEATURES, *REMEMBERED), (*SCALES, *REMEMBERED_SCALES), reputation_gain
)
"""Network on the same observation and on what the robot remembers."""


def network_over(estimator: object) -> WeightingNetwork:
    """Return the architecture of a weighting for an estimator."""
    remembers = isinstance(estimator, ReputationOdometryParameters) and estimator.weighs_unknown
    return REPUTATION_NETWORK if remembers else EXCHANGE_NETWORK


class LearnedLayer(Parameters):
    """Base of layers that run a policy file."""

    policy: str

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files, other than source code, that its output depends on."""
        return (policy_path(self.policy),)


@WEIGHTING_RULES.register("learned")
class LearnedWeighting(LearnedLayer):
    """A trained network sets the weight of a heard estimate.

        g_i = 1 / (1 + exp(-l))
        p_i = (1 - g_i) p_i + g_i p_j

    Not in the papers: all of it but the form, which is that of SGIFF (TR, Eq. 37 and 39) with
    log-odds l that a network adds to (`log_odds`).
    """

    policy: str = Field(
        "weighting",
        description="Network: a bundled policy, or a file such as runs/x/best.safetensors",
    )
    architecture: ClassVar[WeightingNetwork] = EXCHANGE_NETWORK

    def check_usable(self, scenario: object = None) -> None:
        """Raise ConfigError or UnknownNameError if the policy is missing or does not fit."""
        self.architecture.numbers_of(load_policy(self.policy))

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """Return the layer of the policy file. ConfigError if it is missing or does not fit."""
        numbers = self.architecture.numbers_of(load_policy(self.policy))
        return self.architecture.layer(numbers, scenario)


@WEIGHTING_RULES.register("learned_reputation")
class LearnedReputation(LearnedWeighting):
    """A trained network sets the weight of a heard estimate, also by the reputation of its sender.

        g_i = 1 / (1 + exp(-l))
        p_i = (1 - g_i) p_i + g_i p_j

    Not in the papers: all of it but the form, as in `learned`.
    """

    architecture = REPUTATION_NETWORK

    policy: str = Field(
        "weighting-sceptical",
        description="Network: a bundled policy, or a file such as runs/x/best.safetensors",
    )
