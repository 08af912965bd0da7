"""A learned confidence weighting: a small network adds to the log-odds of SGIFF."""

import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32, Float64, Int64
from swarm_forage_env.interface import Encounter
from swarm_forage_env.compiler import kernel
from swarm_forage_env.scenario import Part, Scenario
from swarm_forage_env.waypoints_scenario import AnyScenario
from training.policy_file import Policy, Shapes, Weights, load_policy, policy_path

NETWORK = "log-odds"
"""Name of this architecture on a policy card."""

FEATURES = (
    "own_p",
    "heard_p",
    "disagreement",
    "own_p_elsewhere",
    "own_distance",
    "heard_distance",
    "frames",
    "range",
)
"""Inputs of the network for one area of an exchange."""

SCALES = ((0.1, 3.0, 1.5), (0.1, 3.0, 1.5), (0.1, 2.0, 1.5), (0.1, 3.0, 1.5), (0.1, 2.0, 1.0),
          (0.1, 2.0, 1.0), (1.0, 3.5, 1.5), (0.1, 0.75, 0.25))  # fmt: skip
"""Feature scaling: unit u [m, or frames], centre c and spread s of (ln(1 + x / u) - c) / s, which
maps centimetres as well as tens of metres to within a few units of zero."""

OWN_P, HEARD_P, DISAGREEMENT, OWN_DISTANCE, HEARD_DISTANCE, FRAMES, RANGE = 0, 2, 4, 6, 8, 10, 11
"""Columns of the network inputs; all but the last two have one for each area."""

HIDDEN = 4
"""Default number of hidden units."""


def weighting_network_shapes(sizes: Mapping[str, int]) -> Shapes:
    """Shapes of the arrays of the network, in the order of the flat weights."""
    n = len(FEATURES)
    return {
        "hidden.weight": (sizes["hidden"], n),
        "hidden.bias": (sizes["hidden"],),
        "output.weight": (sizes["hidden"],),
        "direct.weight": (n + 1,),
        "output.bias": (1,),
    }


def flatten(weights: Weights, shapes: Shapes) -> Float64[Array, " numbers"]:
    """Flatten the arrays of a network into one vector of weights."""
    return np.concatenate([weights[name].ravel() for name in shapes]).astype(np.float64)


def unflatten(numbers: Array, shapes: Shapes) -> dict[str, Float32[Array, "..."]]:
    """Unflatten a vector of weights into the arrays of a network, in single precision."""
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])
    parts = np.split(np.asarray(numbers, np.float32), ends[:-1])
    return {
        name: part.reshape(shape) for (name, shape), part in zip(shapes.items(), parts, strict=True)
    }


@kernel
def normalised_features(
    shown: Float64[Array, " columns"], area: int, out_features: Float64[Array, " features"]
) -> None:
    """Scaled features of one area, each (ln(1 + x / u) - c) / s."""
    out_features[0] = shown[OWN_P + area]
    out_features[1] = shown[HEARD_P + area]
    out_features[2] = shown[DISAGREEMENT + area]
    out_features[3] = shown[OWN_P + 1 - area]
    out_features[4] = shown[OWN_DISTANCE + area]
    out_features[5] = shown[HEARD_DISTANCE + area]
    out_features[6] = shown[FRAMES]
    out_features[7] = shown[RANGE]
    for k in range(len(SCALES)):
        unit, centre, spread = SCALES[k]
        out_features[k] = (math.log1p(out_features[k] / unit) - centre) / spread


@kernel
def log_odds(
    features: Float64[Array, " features"], ahead: float, numbers: Float64[Array, " numbers"]
) -> float:
    """Log-odds of the heard estimate; those of SGIFF if all weights are zero.

        l = (1 + d_0) (p_i - p_j) + d . x + w . tanh(V x + v) + b

    x are the features, `ahead` is p_i - p_j [m], and the flat weights are V, v, w, (d, d_0), b.
    """
    n = features.shape[0]
    hidden = (numbers.shape[0] - n - 2) // (n + 2)
    biases, outputs, direct = hidden * n, hidden * (n + 1), hidden * (n + 2)
    total = numbers[direct + n + 1] + (1.0 + numbers[direct + n]) * ahead
    for k in range(n):
        total += numbers[direct + k] * features[k]
    for unit in range(hidden):
        activation = numbers[biases + unit]
        for k in range(n):
            activation += numbers[unit * n + k] * features[k]
        total += numbers[outputs + unit] * math.tanh(activation)
    return float(total)


@kernel
def network_gains(
    shown: Float64[Array, "encounters columns"],
    which: Int64[Array, " encounters"],
    networks: Float64[Array, "networks numbers"],
    out_g: Float32[Array, "encounters areas"],
) -> None:
    """Weight g = 1 / (1 + exp(-l)) of each exchange and area, by the network `which` of its row."""
    features = np.empty(len(SCALES))
    for i in range(shown.shape[0]):
        for area in range(2):
            normalised_features(shown[i], area, features)
            ahead = shown[i, OWN_P + area] - shown[i, HEARD_P + area]
            odds = log_odds(features, ahead, networks[which[i]])
            out_g[i, area] = 0.5 + 0.5 * math.tanh(0.5 * odds)


def network_inputs(
    encounter: Encounter, rows: Int64[Array, " encounters"]
) -> Float64[Array, "rows columns"]:
    """Network inputs of some rows, as a matrix."""
    parts = (
        encounter.own_p[rows],
        encounter.heard_p[rows],
        encounter.disagreement[rows],
        encounter.own_distance[rows],
        encounter.heard_distance[rows],
        encounter.frames[rows],
        encounter.range[rows],
    )
    return np.column_stack(parts).astype(np.float64)


class NetworkWeighting:
    """A running weighting by one network, or by several, each for its own worlds."""

    heard_p_share = 1.0

    def __init__(self, networks: Array, of_row: Int64[Array, " rows"] | None = None) -> None:
        """Take flat weights, a row for each network, and each robot's network (None: the first)."""
        single = np.asarray(networks, np.float32)
        self._networks = single.astype(np.float64)
        self._of_row = of_row

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """Weight g of each row and area; zero where no exchange ended."""
        g = np.zeros_like(encounter.own_p)
        rows = np.flatnonzero(encounter.valid)
        found = np.empty((len(rows), 2), np.float32)
        which = np.zeros_like(rows) if self._of_row is None else self._of_row[rows]
        network_gains(network_inputs(encounter, rows), which, self._networks, found)
        g[rows] = found
        return g


@WEIGHTING_RULES.register("learned")
class LearnedWeighting(Part):
    """A trained network sets the weight of a heard estimate.

        g_i = 1 / (1 + exp(-l))
        p_i = (1 - g_i) p_i + g_i p_j

    Not in the papers: all of it but the form, which is that of SGIFF (TR, Eq. 37 and 39) with
    log-odds l that a network adds to (`log_odds`).
    """

    heard_p_share: ClassVar[float] = 1.0

    policy: str = Field(
        "weighting",
        description="The network: a bundled policy, or a file as runs/x/best.safetensors",
    )

    @cached_property
    def network(self) -> NetworkWeighting:
        """The running network, read from its file at the first use."""
        return NetworkWeighting(network_of(load_policy(self.policy))[None])

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files, other than source code, that its output depends on."""
        return (policy_path(self.policy),)

    def check_usable(self, scenario: AnyScenario | None = None) -> None:
        """ConfigError or UnknownNameError if the policy is missing or does not fit."""
        network_of(load_policy(self.policy))

    def beside(self, estimator: object) -> NetworkWeighting:
        """Return the running network; ConfigError if its file is missing or does not fit."""
        return self.network

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """Weight g of each row and area."""
        return self.network(encounter)


def network_of(policy: Policy) -> Float64[Array, " numbers"]:
    """Flat weights of a policy's weighting network; ConfigError if it does not fit."""
    policy.check_fits("weighting", Scenario())
    shapes = weighting_network_shapes(policy.sizes_of("weighting", NETWORK, ("hidden",)))
    return flatten(policy.weights_of("weighting", shapes), shapes)
