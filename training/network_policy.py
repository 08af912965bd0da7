"""Policies of dense layers, as PPO of `swarm-forage train` saves them; they run without torch.

    x_0 = observation,  x_k+1 = tanh(W_k x_k + b_k),  action = W_n x_n + b_n

The weights are safetensors: `0.weight`, `0.bias` and so on, and `log_std`, the logarithm of the
standard deviation by which the policy acted in training. In a file with arrays `encoder.*` and
`gru.*` a memory lies before the layers, and x_0 is the state of the robot; `training.actor_critic`
has its equations. The card of the same name tells its keywords and its training.
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.policy import Draw, PolicyFile, Predict, Recurrent
from training.policy_card import PolicyCard
from training.policy_file import Shapes, Weights, misfit, packed_weights, read_weights, write_both

LOG_STD = "log_std"

Rows = Float32[Array, "robots numbers"]

Layers = list[tuple[Float32[Array, "inputs outputs"], Float32[Array, " outputs"]]]

GATES = 3  # reset, update and new state, which the arrays of the memory hold one after the other


class NetworkPolicy(PolicyFile):
    """A network that `swarm-forage train` has saved: network:runs/x/best.safetensors."""

    def start(self, form: PolicyForm) -> Predict | Recurrent:
        """The mean action."""
        layers, memory, _ = self._loaded(form)
        if not memory:
            return lambda observed: action_of(layers, observed)

        def step(observed: Rows, states: Rows) -> tuple[Rows, Rows]:
            states = next_states(memory, observed, states)
            return action_of(layers, states), states

        return Recurrent(step, len(memory[-1][0]))

    def start_by_chance(self, form: PolicyForm) -> Draw | Recurrent:
        """The mean action and Gaussian noise, as in training."""
        layers, memory, log_std = self._loaded(form)
        deviation = np.exp(log_std)
        if not memory:
            return lambda observed, draws: action_of(layers, observed) + deviation * draws

        def step(observed: Rows, draws: Rows, states: Rows) -> tuple[Rows, Rows]:
            states = next_states(memory, observed, states)
            return action_of(layers, states) + deviation * draws, states

        return Recurrent(step, len(memory[-1][0]))

    def _loaded(self, form: PolicyForm) -> tuple[Layers, Layers, Float32[Array, " actions"]]:
        """The layers, those of the memory, and the logarithms of deviations.

        ConfigError if they do not fit.
        """
        if form.action.is_discrete:
            raise ConfigError(f"policy {self.file}: gives numbers, not choices; leave out discrete")
        weights, sha256 = read_weights(self.path)
        card = self.card()
        if card is not None and card.training is not None and card.training.sha256 != sha256:
            raise ConfigError(f"policy {self.file}: its card is of other weights")
        shapes = {name: each.shape for name, each in weights.items()}
        n_hidden = max(sum(name.removesuffix(".bias").isdigit() for name in shapes) - 1, 0)
        hidden = [shapes.get(f"{k}.bias", (0,))[0] for k in range(n_hidden)]
        n_state = shapes.get("encoder.bias", (0,))[0]
        other = misfit(
            shapes, shapes_of([len(form.layout), *hidden, len(form.action.layout)], n_state)
        )
        if other:
            raise ConfigError(f"policy {self.file}: does not fit: {other}")

        def layer(weight: str, bias: str) -> tuple[Rows, Float32[Array, " outputs"]]:
            return np.ascontiguousarray(weights[weight].T), weights[bias]

        layers = [layer(f"{k}.weight", f"{k}.bias") for k in range(n_hidden + 1)]
        memory = (
            [
                layer("encoder.weight", "encoder.bias"),
                layer("gru.weight_ih", "gru.bias_ih"),
                layer("gru.weight_hh", "gru.bias_hh"),
            ]
            if n_state
            else []
        )
        return layers, memory, weights[LOG_STD]


def shapes_of(sizes: Sequence[int], n_state: int = 0) -> Shapes:
    """Shapes of the arrays of a network; `sizes` are inputs, hidden units and actions.

    With a memory of `n_state` numbers the layers start from these.
    """
    n_observed, *rest = sizes
    shapes: dict[str, tuple[int, ...]] = {LOG_STD: (sizes[-1],)}
    for k, (n_in, n_out) in enumerate(pairwise([n_state or n_observed, *rest])):
        shapes |= {f"{k}.weight": (n_out, n_in), f"{k}.bias": (n_out,)}
    if n_state:
        shapes |= {"encoder.weight": (n_state, n_observed), "encoder.bias": (n_state,)}
        for name in ("ih", "hh"):
            gates = GATES * n_state
            shapes |= {f"gru.weight_{name}": (gates, n_state), f"gru.bias_{name}": (gates,)}
    return shapes


def next_states(memory: Layers, observed: Rows, states: Rows) -> Rows:
    """The state of each robot after an observation, as a gated recurrent unit makes it."""
    encoder, of_input, of_state = memory
    encoded = np.tanh(product(observed, *encoder))
    r_in, z_in, n_in = np.split(product(encoded, *of_input), GATES, axis=1)
    r_own, z_own, n_own = np.split(product(states, *of_state), GATES, axis=1)
    r, z = _sigmoid(r_in + r_own), _sigmoid(z_in + z_own)
    n = np.tanh(n_in + r * n_own)
    after: Rows = (1.0 - z) * n + z * states
    return after


def _sigmoid(x: Rows) -> Rows:
    """1 / (1 + exp(-x)), without overflow."""
    y: Rows = 0.5 + 0.5 * np.tanh(0.5 * x)
    return y


def action_of(layers: Layers, observed: Rows) -> Rows:
    """The mean action of each robot, bit for bit the same whatever rows are beside it."""
    x = observed
    for k, layer in enumerate(layers):
        x = product(np.tanh(x) if k else x, *layer)
    return x


def product(
    x: Rows, weight: Float32[Array, "inputs outputs"], bias: Float32[Array, " outputs"]
) -> Rows:
    """The rows x weight + bias."""
    out = np.empty((len(x), len(bias)), np.float32)
    multiply(np.ascontiguousarray(x, np.float32), weight, bias, out)
    return out


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
