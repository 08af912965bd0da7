"""Networks of PPO: dense layers, of one policy or of several at once, and recurrent networks.

A gated recurrent unit precedes the dense layers; its state h is zero when an episode starts:

    x_t = tanh(W o_t + b)                          from the observation o_t
    r_t = sigmoid(W_r x_t + b_r + U_r h_t-1 + c_r)
    z_t = sigmoid(W_z x_t + b_z + U_z h_t-1 + c_z)
    n_t = tanh(W_n x_t + b_n + r_t (U_n h_t-1 + c_n))
    h_t = (1 - z_t) n_t + z_t h_t-1

Source: Cho2014, Learning Phrase Representations using RNN Encoder-Decoder (in torch's form).
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.errors import ConfigError

SPAN = 512
"""Largest number of rows in one matrix product: a GPU sums the gradient of the weights over these
rows in a single group of threads."""

HALF_LOG_2_PI = 0.5 * math.log(2.0 * math.pi)


class ActorCritic(nn.Module):
    """Actor and critic of dense layers: a Gaussian over actions, the value of an observation."""

    n_state = 0
    """Size of the recurrent state of a row; 0: none."""

    def __init__(
        self,
        n_observed: int,
        n_actions: int,
        hidden: Sequence[int] = (64, 64),
        log_std: float = 0.0,
        value_gain: float = 1.0,
    ) -> None:
        """Initialise the matrices orthogonally, the last ones with their own gains, as SB3 does.

        With `value_gain=0` all values are 0 at first, so that nothing is learned before the first
        reward: advantages without rewards are differences of untrained values.
        """
        super().__init__()
        self.actor: nn.Module = Dense([n_observed, *hidden, n_actions], gain=0.01)
        self.critic: nn.Module = Dense([n_observed, *hidden, 1], gain=value_gain)
        self.log_std = nn.Parameter(torch.full((n_actions,), log_std))

    def forward(self, observed: Tensor) -> Tensor:
        """Draw an action for each row from the Gaussian."""
        mean, log_std, _ = self.outputs(observed)
        return mean + log_std.exp() * torch.randn_like(mean)

    def outputs(self, observed: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return mean actions, log standard deviations and values; any axes may precede rows."""
        mean, values = (net(observed.flatten(0, -2)) for net in (self.actor, self.critic))
        axes = observed.shape[:-1]
        return mean.view(*axes, -1), self.log_std, values.view(axes)

    def next_states(self, observed: Tensor, states: Tensor) -> Tensor:
        """Return the input of both networks: the state of each row after one observation."""
        return self.states(observed[None], states, observed.new_zeros((1, len(observed))))[0]

    def states(self, observed: Tensor, states: Tensor, ends: Tensor) -> Tensor:
        """Return the state after each decision, decisions by rows; here, the observation.

        `states` precede the first decision; `ends` is 1 where an episode ends with a decision.
        """
        return observed

    def named(self, policy: int, tensors: Sequence[Tensor]) -> dict[str, Tensor]:
        """Return the tensors, one for each parameter, by the names of the parameters."""
        return dict(zip(dict(self.named_parameters()), tensors, strict=True))

    def to_numpy(self) -> dict[str, Float32[Array, "..."]]:
        """Copy the parameters of the actor to NumPy arrays, named as in a policy file."""
        dense = [each for each in self.actor.children() if isinstance(each, nn.Linear)]
        arrays = {
            f"{k}.{name}": each
            for k, layer in enumerate(dense)
            for name, each in layer.named_parameters()
        }
        arrays["log_std"] = self.log_std
        return _copied(arrays)


class RecurrentActorCritic(ActorCritic):
    """Actor and critic on the recurrent state of a robot, which sums up its observations."""

    def __init__(
        self,
        n_observed: int,
        n_actions: int,
        hidden: Sequence[int] = (64, 64),
        log_std: float = 0.0,
        value_gain: float = 1.0,
    ) -> None:
        """Initialise all matrices orthogonally; the first of the `hidden` sizes is the state's."""
        n_state, *rest = hidden
        super().__init__(n_state, n_actions, rest, log_std, value_gain)
        self.n_state = n_state
        self.encoder = Dense([n_observed, n_state], gain=2.0**0.5)
        self.gru = nn.GRU(n_state, n_state)
        for name, parameter in self.gru.named_parameters():
            if name.startswith("weight"):
                nn.init.orthogonal_(parameter)
            else:
                nn.init.zeros_(parameter)

    def states(self, observed: Tensor, states: Tensor, ends: Tensor) -> Tensor:
        """Return the state after each decision, with one call of the unit between two ends.

        On a GPU the unit is called once per decision: reading the ends would wait for the GPU.
        """
        encoded = torch.tanh(self.encoder(observed))
        if encoded.is_cuda:
            return self.each_state(encoded, states, ends)
        starts = 1 + ends[:-1].any(1).nonzero().flatten()
        parts = []
        for first, last in pairwise([0, *starts.tolist(), len(ends)]):
            part, after = self.gru(encoded[first:last], states[None])
            states = after[0] * (1.0 - ends[last - 1])[:, None]
            parts.append(part)
        return torch.cat(parts)

    def each_state(self, encoded: Tensor, states: Tensor, ends: Tensor) -> Tensor:
        """Return the state after each decision, one by one, without copies to the host."""
        gru, after = self.gru, []
        (weights,) = gru.all_weights
        for inputs, going_on in zip(encoded, 1.0 - ends, strict=True):
            after.append(torch.gru_cell(inputs, states, *weights))
            states = after[-1] * going_on[:, None]
        return torch.stack(after)

    def to_numpy(self) -> dict[str, Float32[Array, "..."]]:
        """Copy the recurrent unit and the actor to NumPy arrays, named as in a policy file."""
        (encoder,) = self.encoder
        memory = {f"encoder.{name}": each for name, each in encoder.named_parameters()}
        memory |= {
            f"gru.{name.removesuffix('_l0')}": each for name, each in self.gru.named_parameters()
        }
        return super().to_numpy() | _copied(memory)


class ActorCritics(nn.Module):
    """Dense networks of several policies in one tensor: one matrix product computes a layer of all.

    Each network is a row of `numbers`: the weights and biases of each layer and, for an actor, the
    log standard deviations. The last layer of a critic has as many outputs as that of an actor;
    only the first is used. The parameters of the policies become views of the tensor.
    """

    def __init__(self, policies: Sequence[ActorCritic]) -> None:
        """Join the parameters. ConfigError unless all policies have dense layers of equal sizes."""
        super().__init__()
        if not self.fits(policies):
            raise ConfigError(
                f"{len(policies)} policies side by side: must be dense layers of the same sizes"
            )
        first = policies[0]
        networks = first.actor, first.critic
        self._shapes = [[each.shape for each in net.parameters()] for net in networks]
        self._sizes = [*map(math.prod, self._shapes[0]), len(first.log_std)]
        zeros = first.log_std.new_zeros((2 * len(policies), sum(self._sizes)))
        self.numbers, self._names = nn.Parameter(zeros), list(dict(first.named_parameters()))
        for k, policy in enumerate(policies):
            for name, view in self.named(k, [zeros]).items():
                parameter = policy.get_parameter(name)
                view.copy_(parameter.detach())
                parameter.data = view

    @staticmethod
    def fits(policies: Sequence[ActorCritic]) -> bool:
        """Return whether all policies are dense layers of the same sizes."""
        if not all(type(each) is ActorCritic for each in policies):
            return False
        networks = [net for each in policies for net in (each.actor, each.critic)]
        return len({net.sizes[:-1] if isinstance(net, Dense) else net for net in networks}) == 1

    def outputs(self, observed: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return the outputs of each policy; `observed` is (policies, rows, features)."""
        n_policies, n_rows, n_observed = observed.shape
        n = -(-n_rows // SPAN)
        numbers = self.numbers[:, None].expand(-1, n, -1).flatten(0, 1)
        *layers, log_std = torch.split(numbers, self._sizes, 1)
        padded = nn.functional.pad(observed, (0, 0, 0, -n_rows % n)) if n_rows % n else observed
        spans = padded.reshape(n_policies, 1, n, -1, n_observed)
        flowing = spans.expand(-1, 2, -1, -1, -1).flatten(0, 2)
        for k in range(0, len(layers), 2):
            flowing = torch.tanh(flowing) if k else flowing
            weights = layers[k].view(len(flowing), -1, flowing.shape[2])
            flowing = torch.baddbmm(layers[k + 1][:, None], flowing, weights.mT)
        outputs = flowing.view(n_policies, 2, -1, flowing.shape[2])[:, :, :n_rows]
        mean, values = outputs.unbind(1)
        return mean, log_std[:: 2 * n, None], values[..., 0]

    def named(self, policy: int, tensors: Sequence[Tensor]) -> dict[str, Tensor]:
        """Return views of a tensor laid out as `numbers`, by the names of a policy's parameters."""
        (numbers,) = tensors
        rows = numbers[2 * policy : 2 * policy + 2]
        views = [rows[0, -self._sizes[-1] :]]
        for row, shapes in zip(rows, self._shapes, strict=True):
            parts = zip(torch.split(row, self._sizes), shapes, strict=False)
            views += [part[: math.prod(shape)].view(shape) for part, shape in parts]
        return dict(zip(self._names, views, strict=True))


def log_probs_of(actions: Tensor, mean: Tensor, log_std: Tensor) -> Tensor:
    """Return the log probability of each row of actions under a Gaussian."""
    z = (actions - mean) * torch.exp(-log_std)
    return -0.5 * z.square().sum(-1) - (log_std + HALF_LOG_2_PI).sum(-1)


class Dense(nn.Sequential):
    """Dense layers with a hyperbolic tangent between them."""

    def __init__(self, sizes: Sequence[int], gain: float) -> None:
        """Initialise the matrices orthogonally; `gain` scales the last one."""
        layers: list[nn.Module] = []
        for k in range(1, len(sizes)):
            layer = nn.Linear(sizes[k - 1], sizes[k])
            nn.init.orthogonal_(layer.weight, gain if k == len(sizes) - 1 else 2.0**0.5)
            nn.init.zeros_(layer.bias)
            layers += [layer, nn.Tanh()]
        super().__init__(*layers[:-1])
        self.sizes = tuple(sizes)


def _copied(parameters: Mapping[str, Tensor]) -> dict[str, Float32[Array, "..."]]:
    return {name: each.detach().cpu().numpy().copy() for name, each in parameters.items()}
