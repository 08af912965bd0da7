"""Policies of dense layers, as saved by PPO of `swarm-forage train`; they run without torch.

    x_0 = observation,  x_k+1 = tanh(W_k x_k + b_k),  action = W_n x_n + b_n

The weights are safetensors: `0.weight`, `0.bias` and so on, and `log_std`, the logarithm of the
standard deviation of the actions in training. With arrays `encoder.*` and `gru.*`, a recurrent unit
precedes the layers, and x_0 is its state; `training.actor_critic` has the equations. The card of
the same name records the keywords and the training.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.envs.pilot import Pilot
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.equations.elementary import tanh
from swarm_forage_env.errors import ConfigError
from training.policy import PolicyFile, Rows, Started
from training.policy_card import PolicyCard
from training.policy_file import Shapes, Weights, misfit, packed_weights, read_weights, write_both

LOG_STD = "log_std"

BUNDLED_NETWORKS = {
    file.stem: file for file in (Path(__file__).parent / "networks").glob("*.safetensors")
}
"""Files of the bundled networks by name."""

GATES = 3  # reset, update and new state, in this order in the arrays of the recurrent unit


class NetworkPolicy(PolicyFile):
    """A network that `swarm-forage train` has saved: network:runs/x/best.safetensors."""

    @property
    def path(self) -> Path:
        """Path of the bundled network of this name, or else of the file; ConfigError if neither."""
        return BUNDLED_NETWORKS.get(self.file) or super().path

    def start(self, form: PolicyForm) -> Started:
        """Start the network: its mean action, if stochastic with Gaussian noise as in training."""
        network, log_std = self._loaded(form)
        deviation = np.exp(log_std)

        def act(observed: Rows, draws: Array | None, states: Rows) -> tuple[Rows, Rows]:
            actions, after = network(observed, states)
            return actions if draws is None else actions + deviation * draws, after

        return Started(act, network.n_state, has_distribution=True)

    def pilot(self, form: PolicyForm) -> Pilot:
        """Return the network, which takes the mean action, to be compiled with the world."""
        return self._loaded(form)[0].pilot(form)

    def _loaded(self, form: PolicyForm) -> tuple["Network", Float32[Array, " actions"]]:
        """Return the network and the log standard deviations. ConfigError if they do not fit."""
        if form.action.is_discrete:
            raise ConfigError(f"policy {self.file}: gives continuous actions; leave out discrete")
        weights, sha256 = read_weights(self.path)
        card = self.card()
        if card is not None and card.training is not None and card.training.sha256 != sha256:
            raise ConfigError(f"policy {self.file}: its card belongs to other weights")
        shapes = {name: each.shape for name, each in weights.items()}
        n_hidden = max(sum(name.removesuffix(".bias").isdigit() for name in shapes) - 1, 0)
        hidden = [shapes.get(f"{k}.bias", (0,))[0] for k in range(n_hidden)]
        n_state = shapes.get("encoder.bias", (0,))[0]
        sizes = [len(form.layout), *hidden, len(form.action.layout)]
        other = misfit(shapes, shapes_of(sizes, n_state))
        if other:
            raise ConfigError(f"policy {self.file}: does not fit: {other}")
        names = [(f"{k}.weight", f"{k}.bias") for k in range(n_hidden + 1)]
        if n_state:
            names = [*MEMORY, *names]
        network = Network(packed_layers(weights, names), np.array([n_state, *sizes]))
        return network, weights[LOG_STD]


MEMORY = (
    ("encoder.weight", "encoder.bias"),
    ("gru.weight_ih", "gru.bias_ih"),
    ("gru.weight_hh", "gru.bias_hh"),
)
"""Arrays of the recurrent unit, which precedes the layers."""


def packed_layers(weights: Weights, names: Iterable[tuple[str, str]]) -> Float32[Array, " numbers"]:
    """Pack layers, named by their arrays: of each, the matrix (inputs, outputs) and the bias."""
    return np.concatenate([part for w, b in names for part in (weights[w].T.ravel(), weights[b])])


@dataclass(frozen=True)
class Network:
    """Packed layers of a network, after a recurrent unit if there is one."""

    numbers: Float32[Array, " numbers"]
    """Weights and biases, as packed by `packed_layers`."""
    sizes: Int64[Array, " sizes"]
    """Sizes of the recurrent state, the observation, each hidden layer, and the action."""

    @property
    def n_state(self) -> int:
        """Size of a robot's recurrent state; 0: none."""
        return int(self.sizes[0])

    @property
    def n_between(self) -> int:
        """Size of the working memory of `forward`."""
        return 2 * int(self.sizes[1:].max()) + (1 + 2 * GATES) * self.n_state

    def pilot(self, form: PolicyForm) -> Pilot:
        """Return the network, to be compiled with a world."""
        return Pilot(form, forward, self.numbers, self.sizes, self.n_state, self.n_between)

    def __call__(self, observed: Rows, states: Rows) -> tuple[Rows, Rows]:
        """Return the mean action and the next state of each robot.

        They do not depend on the other rows, bit for bit.
        """
        after, actions = states.copy(), np.empty((len(observed), self.sizes[-1]), np.float32)
        seen, between = np.ascontiguousarray(observed, np.float32), self.n_between
        forward_rows(seen, self.numbers, self.sizes, after, np.empty(between, np.float32), actions)
        return actions, after


def shapes_of(sizes: Sequence[int], n_state: int = 0) -> Shapes:
    """Return the shapes of a network's arrays; `sizes` are inputs, hidden units and actions.

    With `n_state` > 0, a recurrent unit with a state of this size precedes the layers.
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


@kernel
def forward(
    observed: Float32[Array, " inputs"],
    numbers: Float32[Array, " numbers"],
    sizes: Int64[Array, " sizes"],
    state: Float32[Array, " state"],
    between: Float32[Array, " between"],
    out: Float32[Array, " actions"],
) -> None:
    """Write the mean action of a robot, and advance its state."""
    n_state, widest, at = sizes[0], 0, 0
    for k in range(1, sizes.shape[0]):
        widest = max(widest, sizes[k])
    a, b = between[:widest], between[widest : 2 * widest]
    n_in = sizes[1]
    for k in range(n_in):
        a[k] = observed[k]
    if n_state > 0:
        at = remember(a, numbers, n_in, state, between[2 * widest :])
        n_in = n_state
        for k in range(n_state):
            a[k] = state[k]
    for layer in range(2, sizes.shape[0]):
        n_out = sizes[layer]
        multiply(a[:n_in], numbers, at, b[:n_out])
        at, n_in = at + n_out * (n_in + 1), n_out
        is_last = layer == sizes.shape[0] - 1
        for k in range(n_out):
            if is_last:
                out[k] = b[k]
            else:
                a[k] = tanh(b[k])


@kernel
def remember(
    observed: Float32[Array, " inputs"],
    numbers: Float32[Array, " numbers"],
    n_in: int,
    state: Float32[Array, " state"],
    between: Float32[Array, " between"],
) -> int:
    """Advance the state by a gated recurrent unit; return the offset of the layers' weights."""
    n = state.shape[0]
    encoded, of_input, of_state = between[:n], between[n : 4 * n], between[4 * n : 7 * n]
    multiply(observed[:n_in], numbers, 0, encoded)
    for k in range(n):
        encoded[k] = tanh(encoded[k])
    at = n * (n_in + 1)
    size = 3 * n * (n + 1)
    multiply(encoded, numbers, at, of_input)
    multiply(state, numbers, at + size, of_state)
    for k in range(n):
        reset = sigmoid(of_input[k] + of_state[k])
        update = sigmoid(of_input[n + k] + of_state[n + k])
        new = tanh(of_input[2 * n + k] + reset * of_state[2 * n + k])
        state[k] = (1.0 - update) * new + update * state[k]
    return int(at + 2 * size)


@kernel
def sigmoid(x: float) -> float:
    """Return 1 / (1 + exp(-x)), without overflow."""
    return 0.5 + 0.5 * tanh(0.5 * x)


@kernel
def multiply(
    x: Float32[Array, " inputs"],
    numbers: Float32[Array, " numbers"],
    at: int,
    out: Float32[Array, " outputs"],
) -> None:
    """Write x W + b, with W and b from offset `at` on; the order of the sums is fixed."""
    n_in, n_out = x.shape[0], out.shape[0]
    for j in range(n_out):
        out[j] = numbers[at + n_in * n_out + j]
    for k in range(n_in):
        for j in range(n_out):
            out[j] += x[k] * numbers[at + k * n_out + j]


@entry_point
def forward_rows(
    observed: Float32[Array, "robots inputs"],
    numbers: Float32[Array, " numbers"],
    sizes: Int64[Array, " sizes"],
    states: Float32[Array, "robots state"],
    between: Float32[Array, " between"],
    out: Float32[Array, "robots actions"],
) -> None:
    """Write the mean actions of robots, and advance their states."""
    for i in range(observed.shape[0]):
        forward(observed[i], numbers, sizes, states[i], between, out[i])


def save_network(file: Path, weights: Weights, card: PolicyCard) -> None:
    """Write the weights of a network and its card to files, each atomically."""
    content, sha256 = packed_weights(file, weights)
    training = card.training and card.training.model_copy(update={"sha256": sha256})
    write_both(file, content, card.model_copy(update={"training": training}))
