"""The networks of PPO: dense layers, and dense layers over a memory of each robot.

The memory is a gated recurrent unit, whose state h is zeros when an episode starts:

    x_t = tanh(W o_t + b)                          of the observation o_t
    r_t = sigmoid(W_r x_t + b_r + U_r h_t-1 + c_r)
    z_t = sigmoid(W_z x_t + b_z + U_z h_t-1 + c_z)
    n_t = tanh(W_n x_t + b_n + r_t (U_n h_t-1 + c_n))
    h_t = (1 - z_t) n_t + z_t h_t-1

Source: Cho2014, Learning Phrase Representations using RNN Encoder-Decoder; the form is torch's.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import cast

import torch
from torch import Tensor, nn

from swarm_forage_env.arrays import Array, Float32

HALF_LOG_2_PI = 0.5 * math.log(2.0 * math.pi)


class ActorCritic(nn.Module):
    """Two networks of dense layers: a Gaussian over actions, and the value of an observation."""

    def __init__(
        self,
        n_observed: int,
        n_actions: int,
        hidden: Sequence[int] = (64, 64),
        log_std: float = 0.0,
    ) -> None:
        """Initialise matrices orthogonally, the last ones with their own gain, as SB3."""
        super().__init__()
        self.actor = dense([n_observed, *hidden, n_actions], gain=0.01)
        self.critic = dense([n_observed, *hidden, 1], gain=1.0)
        self.log_std = nn.Parameter(torch.full((n_actions,), log_std))

    def forward(self, observed: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Draw actions; return them, the values and the log probability of each row."""
        mean, deviation = self.actor(observed), self.log_std.exp()
        actions = mean + deviation * torch.randn_like(mean)
        return actions, self.critic(observed), log_probs_of(actions, mean, self.log_std)

    def evaluate_actions(self, observed: Tensor, actions: Tensor) -> tuple[Tensor, Tensor, None]:
        """Return the values and the log probabilities of actions; the entropy is left out."""
        log_probs = log_probs_of(actions, self.actor(observed), self.log_std)
        return self.critic(observed), log_probs, None

    def predict_values(self, observed: Tensor) -> Tensor:
        """Return the value of each row."""
        return cast(Tensor, self.critic(observed))

    def to_numpy(self) -> dict[str, Float32[Array, "..."]]:
        """Copy the actor to NumPy arrays, as a policy file holds it."""
        dense = [each for each in self.actor if isinstance(each, nn.Linear)]
        arrays = {
            f"{k}.{name}": each
            for k, layer in enumerate(dense)
            for name, each in layer.named_parameters()
        }
        arrays["log_std"] = self.log_std
        return _copied(arrays)


class RecurrentActorCritic(ActorCritic):
    """Both networks over the state of a robot, which holds what it has observed so far."""

    def __init__(
        self,
        n_observed: int,
        n_actions: int,
        hidden: Sequence[int] = (64, 64),
        log_std: float = 0.0,
    ) -> None:
        """The first of the `hidden` sizes is that of the state; all matrices start orthogonal."""
        n_state, *rest = hidden
        super().__init__(n_state, n_actions, rest, log_std)
        self.n_state = n_state
        self.encoder = dense([n_observed, n_state], gain=2.0**0.5)
        self.gru = nn.GRU(n_state, n_state)
        for name, parameter in self.gru.named_parameters():
            if name.startswith("weight"):
                nn.init.orthogonal_(parameter)
            else:
                nn.init.zeros_(parameter)

    def next_states(self, observed: Tensor, states: Tensor) -> Tensor:
        """The states of rows after an observation of each."""
        return self._run(observed[None], states, observed.new_zeros((1, len(observed))))[0]

    def evaluate_sequences(
        self, observed: Tensor, actions: Tensor, states: Tensor, ends: Tensor
    ) -> tuple[Tensor, Tensor]:
        """The values and the log probabilities of actions, decisions by rows.

        `states` are those before the first decision, `ends` is 1 where an episode ends with one.
        """
        after = self._run(observed, states, ends)
        values, log_probs, _ = self.evaluate_actions(after.flatten(0, 1), actions.flatten(0, 1))
        return values.view(ends.shape), log_probs.view(ends.shape)

    def _run(self, observed: Tensor, states: Tensor, ends: Tensor) -> Tensor:
        """The states after each decision: one call of the unit from one end to the next."""
        encoded = torch.tanh(self.encoder(observed))
        starts = 1 + ends[:-1].any(1).nonzero().flatten()
        parts = []
        for first, last in pairwise([0, *starts.tolist(), len(ends)]):
            part, after = self.gru(encoded[first:last], states[None])
            states = after[0] * (1.0 - ends[last - 1])[:, None]
            parts.append(part)
        return torch.cat(parts)

    def to_numpy(self) -> dict[str, Float32[Array, "..."]]:
        """Copy memory and actor to NumPy arrays, as a policy file holds them."""
        (encoder,) = self.encoder
        memory = {f"encoder.{name}": each for name, each in encoder.named_parameters()}
        memory |= {
            f"gru.{name.removesuffix('_l0')}": each for name, each in self.gru.named_parameters()
        }
        return super().to_numpy() | _copied(memory)


def log_probs_of(actions: Tensor, mean: Tensor, log_std: Tensor) -> Tensor:
    """The log probability of each row of actions under a Gaussian."""
    z = (actions - mean) * torch.exp(-log_std)
    return -(0.5 * z**2 + log_std + HALF_LOG_2_PI).sum(1)


def dense(sizes: Sequence[int], gain: float) -> nn.Sequential:
    """Dense layers with a hyperbolic tangent between them."""
    layers: list[nn.Module] = []
    for k in range(1, len(sizes)):
        layer = nn.Linear(sizes[k - 1], sizes[k])
        nn.init.orthogonal_(layer.weight, gain if k == len(sizes) - 1 else 2.0**0.5)
        nn.init.zeros_(layer.bias)
        layers += [layer, nn.Tanh()]
    return nn.Sequential(*layers[:-1])


def _copied(parameters: Mapping[str, Tensor]) -> dict[str, Float32[Array, "..."]]:
    return {name: each.detach().cpu().numpy().copy() for name, each in parameters.items()}
