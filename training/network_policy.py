"""Policies of dense layers, as PPO of `swarm-forage train` saves them; they run without torch.

    x_0 = observation,  x_k+1 = tanh(W_k x_k + b_k),  action = W_n x_n + b_n

The weights are safetensors: `0.weight`, `0.bias` and so on, and `log_std`, the logarithm of the
standard deviation by which the policy acted in training. The card of the same name tells its
keywords and its training.
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.policy import Draw, PolicyFile, Predict
from training.policy_card import PolicyCard
from training.policy_file import Shapes, Weights, misfit, packed_weights, read_weights, write_both

LOG_STD = "log_std"

Layers = list[tuple[Float32[Array, "inputs outputs"], Float32[Array, " outputs"]]]


class NetworkPolicy(PolicyFile):
    """A network that `swarm-forage train` has saved: network:runs/x/best.safetensors."""

    def start(self, form: PolicyForm) -> Predict:
        """The mean action."""
        layers, _ = self._loaded(form)
        return lambda observed: action_of(layers, observed)

    def start_by_chance(self, form: PolicyForm) -> Draw:
        """The mean action and Gaussian noise, as in training."""
        layers, log_std = self._loaded(form)
        deviation = np.exp(log_std)
        return lambda observed, draws: action_of(layers, observed) + deviation * draws

    def _loaded(self, form: PolicyForm) -> tuple[Layers, Float32[Array, " actions"]]:
        """The layers and the logarithms of deviations; ConfigError if they do not fit."""
        if form.action.is_discrete:
            raise ConfigError(f"policy {self.file}: gives numbers, not choices; leave out discrete")
        weights, sha256 = read_weights(self.path)
        card = self.card()
        if card is not None and card.training is not None and card.training.sha256 != sha256:
            raise ConfigError(f"policy {self.file}: its card is of other weights")
        shapes = {name: each.shape for name, each in weights.items()}
        n_hidden = max(sum(name.endswith(".bias") for name in shapes) - 1, 0)
        hidden = [shapes.get(f"{k}.bias", (0,))[0] for k in range(n_hidden)]
        other = misfit(shapes, shapes_of([len(form.layout), *hidden, len(form.action.layout)]))
        if other:
            raise ConfigError(f"policy {self.file}: does not fit: {other}")
        layers = [
            (np.ascontiguousarray(weights[f"{k}.weight"].T), weights[f"{k}.bias"])
            for k in range(n_hidden + 1)
        ]
        return layers, weights[LOG_STD]


def shapes_of(sizes: Sequence[int]) -> Shapes:
    """Shapes of the arrays of a network; `sizes` are inputs, hidden units and actions."""
    shapes: dict[str, tuple[int, ...]] = {LOG_STD: (sizes[-1],)}
    for k, (n_in, n_out) in enumerate(pairwise(sizes)):
        shapes |= {f"{k}.weight": (n_out, n_in), f"{k}.bias": (n_out,)}
    return shapes


def action_of(
    layers: Layers, observed: Float32[Array, "robots numbers"]
) -> Float32[Array, "robots numbers"]:
    """The mean action of each robot, bit for bit the same whatever rows are beside it."""
    x = np.ascontiguousarray(observed, np.float32)
    for k, (weight, bias) in enumerate(layers):
        rows = np.empty((len(x), len(bias)), np.float32)
        multiply(np.tanh(x) if k else x, weight, bias, rows)
        x = rows
    return x


@entry_point
def multiply(
    x: Float32[Array, "rows inputs"],
    weight: Float32[Array, "inputs outputs"],
    bias: Float32[Array, " outputs"],
    out: Float32[Array, "rows outputs"],
) -> None:
    """Compute out = x weight + bias, row by row.

    The order is fixed: the rounding of a BLAS product depends on the number of rows.
    """
    for i in range(x.shape[0]):
        out[i, :] = bias
        for k in range(x.shape[1]):
            for j in range(bias.shape[0]):
                out[i, j] += x[i, k] * weight[k, j]


def save_network(file: Path, weights: Weights, card: PolicyCard) -> None:
    """Write the weights of a network and its card to files, each atomically."""
    content, sha256 = packed_weights(file, weights)
    training = card.training and card.training.model_copy(update={"sha256": sha256})
    write_both(file, content, card.model_copy(update={"training": training}))
