"""A learned motion: a deep-set network maps the inputs of subsumption to wheel speeds.

    m_k    = tanh(A f(beam_k) + a)                    for each message k
    z      = [f(own), sum_k m_k, max_k m_k]           invariant to the order of the messages
    wheels = clip(C tanh(B tanh(D z + d) + b) + c, -1, 1)

The features f have hand-chosen scales, as observations stay far inside their bounds: directions
as cosine and sine, distances d as d / (d + near) and d / (d + far). Communication takes control
of the motors (TR, Section 5.2): a robot that is talking stands still, whatever the network's
output, as under subsumption, and so averages more messages. The network is deterministic and has
no memory, so a robot without a goal searches deterministically.

The same function runs on NumPy arrays here and on torch tensors in training.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import Part
from swarm_forage_env.record import Rows
from swarm_forage_env.task import task_of
from training import linear_motion_policy
from training.policy_file import (
    Policy,
    Shapes,
    Weights,
    load_policy,
    observation_layout,
    policy_path,
)

if TYPE_CHECKING:
    from torch import Tensor

NETWORK = "deep-set-motion"
SIZES = {"message": 16, "hidden": 64}
"""Sizes of the default network."""

NEAR, FAR = 0.15, 1.5
"""Length scales of the distance features [m]: between robots, and between areas."""

LONG_PATH = 2.0
"""Length scale of the path feature p / (p + LONG_PATH) [m]."""

OWN, MESSAGE = 33, 5
"""Number of features of the robot itself, and of each message."""

Columns = Mapping[str, slice]
"""Columns of each field in a matrix of observations."""

ArrayT = TypeVar("ArrayT", Array, "Tensor")
"""Arrays of NumPy, or of torch; `xp` is the module."""


def motion_network_shapes(sizes: Mapping[str, int]) -> Shapes:
    """Shapes of the arrays of a motion network of these sizes."""
    message, hidden = sizes["message"], sizes["hidden"]
    layers = {
        "message": (message, MESSAGE),
        "first": (hidden, OWN + 2 * message),
        "second": (hidden, hidden),
        "wheels": (2, hidden),
    }
    weights = {f"{name}.weight": shape for name, shape in layers.items()}
    return {**weights, **{f"{name}.bias": shape[:1] for name, shape in layers.items()}}


def wheel_speeds(
    weights: Mapping[str, ArrayT], observed: ArrayT, columns: Columns, xp: ModuleType
) -> ArrayT:
    """Left and right wheel speed of each row, unclipped."""
    pooled = pooled_features(weights, observed, columns, xp)
    hidden: ArrayT = xp.tanh(dense_layer(weights, "first", pooled))
    hidden = xp.tanh(dense_layer(weights, "second", hidden))
    return dense_layer(weights, "wheels", hidden)


def pooled_features(
    weights: Mapping[str, ArrayT], observed: ArrayT, columns: Columns, xp: ModuleType
) -> ArrayT:
    """Features of each row: its own, then sum and maximum of its encoded messages."""
    heard = observed[:, columns["heard"]][:, :, None]
    beam = observed[:, columns["beam"]].reshape(len(observed), -1, 3)
    told = heard * xp.tanh(dense_layer(weights, "message", _message_features(beam, xp)))
    own = _own_features(observed, columns, xp)
    features: ArrayT = xp.concatenate([own, told.sum(1), xp.amax(told, 1)], 1)
    return features


def dense_layer(weights: Mapping[str, ArrayT], name: str, x: ArrayT) -> ArrayT:
    """Apply one dense layer, W x + b, along the last axis.

    NumPy arrays are multiplied row by row in a fixed order: the rounding of a BLAS product depends
    on the number of rows, and a world in a batch would differ from the same world alone.
    """
    weight, bias = weights[f"{name}.weight"], weights[f"{name}.bias"]
    if not isinstance(x, np.ndarray):
        return x @ weight.T + bias
    out = np.empty((*x.shape[:-1], len(bias)), np.float32)
    rows = np.ascontiguousarray(x).reshape(-1, x.shape[-1])
    multiply(rows, np.ascontiguousarray(weight.T), bias, out.reshape(-1, len(bias)))
    return out


@entry_point
def multiply(
    x: Float32[Array, "rows inputs"],
    weight: Float32[Array, "inputs outputs"],
    bias: Float32[Array, " outputs"],
    out: Float32[Array, "rows outputs"],
) -> None:
    """Compute out = x weight + bias, row by row."""
    for i in range(x.shape[0]):
        out[i, :] = bias
        for k in range(x.shape[1]):
            for j in range(bias.shape[0]):
                out[i, j] += x[i, k] * weight[k, j]


def _own_features(observed: ArrayT, columns: Columns, xp: ModuleType) -> ArrayT:
    plain = ("proximity", "ground", "known", "goal", "talking", "wheels")
    places = xp.concatenate([observed[:, columns["target"]], observed[:, columns["areas"]]], 1)
    p = observed[:, columns["p"]]
    parts: list[ArrayT] = [observed[:, columns[name]] for name in plain]
    features: ArrayT = xp.concatenate([*parts, p / (p + LONG_PATH), _place_features(places, xp)], 1)
    return features


def _place_features(places: ArrayT, xp: ModuleType) -> ArrayT:
    """Cosine, sine and two scaled distances of each place; zeros for an unknown place."""
    x, y = places[:, 0::2], places[:, 1::2]
    d = xp.sqrt(x * x + y * y)
    parts = [x / (d + 1e-6), y / (d + 1e-6), d / (d + NEAR), d / (d + FAR)]
    features: ArrayT = xp.concatenate(parts, 1)
    return features


def _message_features(beam: ArrayT, xp: ModuleType) -> ArrayT:
    length, bearings = beam[:, :, :1], beam[:, :, 1:]
    parts: list[ArrayT] = [length / (length + NEAR), xp.cos(bearings), xp.sin(bearings)]
    features: ArrayT = xp.concatenate(parts, 2)
    return features


@MOTIONS.register("learned")
class LearnedMotion(Part):
    """A trained policy sets the wheel speeds. Not in the papers: all of it."""

    policy: str = Field(
        "motion", description="The network: a bundled policy, or a file as runs/x/best.safetensors"
    )

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files, other than source code, that its output depends on."""
        return (policy_path(self.policy),)

    def check_usable(self, scenario: Any = None) -> None:  # noqa: ANN401 of any task
        """ConfigError or UnknownNameError if the policy is missing or does not fit."""
        policy = load_policy(self.policy)
        if scenario is not None and task_of(scenario).name == "foraging":
            policy.check_fits("motion", scenario)
        if _is_linear(policy):
            linear_motion_policy.linear_policy_of(policy)
        else:
            motion_weights(policy)

    def layer(self, scenario: Scenario) -> MotionLayer | None:
        """The compiled motion of a linear policy; None for a deep-set network, which `start` runs.

        ConfigError if the policy does not fit.
        """
        policy = load_policy(self.policy)
        policy.check_fits("motion", scenario)
        if not _is_linear(policy):
            return None
        return linear_motion_policy.linear_motion(
            linear_motion_policy.linear_policy_of(policy), scenario
        )

    def start(self, scenario: Scenario, seeds: Sequence[int]) -> "NetworkMotion":
        """Start a deep-set network in several worlds; ConfigError if the policy does not fit."""
        policy = load_policy(self.policy)
        policy.check_fits("motion", scenario)
        return NetworkMotion(motion_weights(policy), scenario)


def _is_linear(policy: Policy) -> bool:
    layer = policy.card.layers.get("motion")
    return layer is not None and layer.network == linear_motion_policy.NETWORK


def motion_weights(policy: Policy) -> Weights:
    """Weights of a policy's motion network; ConfigError if its architecture is another one."""
    sizes = policy.sizes_of("motion", NETWORK, tuple(SIZES))
    return policy.weights_of("motion", motion_network_shapes(sizes))


class NetworkMotion:
    """The running motion of all robots of several worlds, by a deep-set network."""

    def __init__(self, weights: Weights, scenario: Scenario) -> None:
        """Start the motion: all robots run the same network."""
        self._weights, self._layout = weights, observation_layout("motion", scenario)
        self._columns = self._layout.columns("situation")

    def __call__(
        self, situation: Rows, readings: Rows, heard: Rows, wheels: Float32[Array, "rows 2"]
    ) -> Float32[Array, "rows 2"]:
        """Left and right wheel speed of every robot, as a share of cruise speed in [-1, 1]."""
        seen = {"situation": situation, "readings": readings, "heard": heard}
        observed = self._layout.matrix({**seen, "command": {"wheels": wheels}})
        output = wheel_speeds(self._weights, observed, self._columns, np)
        output[situation.is_talking > 0.0] = 0.0
        return np.asarray(np.clip(output, -1.0, 1.0))

    def reset(self, world: int, seed: int) -> None:
        """Start a new episode; the network has no memory to reset."""
