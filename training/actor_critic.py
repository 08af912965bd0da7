"""Actor and critic networks of the learned layers in PyTorch, one actor for each layer.

An action has no effect where no exchange ends (weighting) or where a robot is talking (motion).
In such steps the action distribution does not depend on the parameters (mean zero, tiny standard
deviation), so the policy gradient is zero there.
"""

from collections.abc import Mapping
from typing import ClassVar, cast

import torch
from torch import Tensor, nn
from torch.distributions import Normal

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.observed_fields import FieldLayout
from training.learned_motion import (
    NETWORK,
    SIZES,
    dense_layer,
    motion_network_shapes,
    pooled_features,
    wheel_speeds,
)
from training.learned_weighting import EXCHANGE_NETWORK, HIDDEN, REMEMBERED, REPUTATION_NETWORK
from training.policy_file import LayerName, Shapes, Weights, action_features

LOG_STD_WITHOUT_EFFECT = -5.0
"""Logarithm of the standard deviation of an action that has no effect."""

GAIN = 0.01
"""Gain of the orthogonal initialisation of an actor's last layer: actions start near zero."""


class NamedNetwork(nn.Module):
    """A network of dense layers whose parameters have the names and shapes of a policy file."""

    network: ClassVar[str]
    """Name of the architecture on a policy card."""
    sizes: Mapping[str, int]

    def __init__(self, shapes: Shapes, last: str, gain: float) -> None:
        """Initialise matrices orthogonally, the last layer's with its own gain; biases are zero."""
        super().__init__()
        for name, shape in shapes.items():
            layer, _, array = name.partition(".")
            if layer not in dict(self.named_children()):
                self.add_module(layer, nn.Module())
            made = nn.Parameter(torch.zeros(shape))
            if len(shape) > 1:
                nn.init.orthogonal_(made, gain if layer == last else 2.0**0.5)
            self.get_submodule(layer).register_parameter(array, made)

    @property
    def arrays(self) -> dict[str, Tensor]:
        """All parameters by name."""
        return dict(self.named_parameters())

    def to_numpy(self) -> dict[str, Float32[Array, "..."]]:
        """Copy all parameters to NumPy arrays, as a policy file holds them."""
        return {name: array.detach().cpu().numpy().copy() for name, array in self.arrays.items()}

    def load_numpy(self, arrays: Weights) -> None:
        """Set all parameters from NumPy arrays, by name."""
        self.load_state_dict({name: torch.from_numpy(array) for name, array in arrays.items()})


class MotionActor(NamedNetwork):
    """The actor of a learned motion: the network of `training.learned_motion` in PyTorch."""

    network = NETWORK
    sizes = SIZES

    def __init__(self, layout: FieldLayout) -> None:
        """Make a network for observations of this layout."""
        super().__init__(motion_network_shapes(SIZES), "wheels", GAIN)
        self._columns = layout.columns("situation")

    def forward(self, observed: Tensor) -> tuple[Tensor, Tensor]:
        """Return the wheel speeds, and 1 where they have an effect, else 0."""
        moves = 1.0 - observed[:, self._columns["talking"]]
        wheels = wheel_speeds(self.arrays, observed, self._columns, torch)
        return wheels * moves, moves.expand(-1, 2)


class MotionCritic(NamedNetwork):
    """The critic of a learned motion: the state value, by a network of the same form."""

    def __init__(self, layout: FieldLayout) -> None:
        """Make a network for observations of this layout."""
        of_actor = motion_network_shapes(SIZES)
        shapes = {name: of_actor[name] for name in of_actor if not name.startswith("wheels")}
        value = {"value.weight": (1, SIZES["hidden"]), "value.bias": (1,)}
        super().__init__({**shapes, **value}, "value", 1.0)
        self._columns = layout.columns("situation")

    def forward(self, observed: Tensor) -> Tensor:
        """Return the state value of each row."""
        arrays = self.arrays
        pooled = pooled_features(arrays, observed, self._columns, torch)
        hidden = torch.tanh(dense_layer(arrays, "first", pooled))
        return dense_layer(arrays, "value", torch.tanh(dense_layer(arrays, "second", hidden)))


class WeightingActor(NamedNetwork):
    """The actor of a learned weighting: the network of `training.learned_weighting` in PyTorch."""

    architecture = EXCHANGE_NETWORK
    network = architecture.name
    unit: Tensor
    centre: Tensor
    spread: Tensor

    def __init__(self, layout: FieldLayout, hidden: int = HIDDEN) -> None:
        """Make a network for observations of this layout, with `hidden` hidden units."""
        self.sizes = {"hidden": hidden}
        super().__init__(self.architecture.shapes(self.sizes), "output", GAIN)
        self._columns = layout.columns("encounter")
        scales = torch.tensor(self.architecture.scales)
        for name, column in zip(("unit", "centre", "spread"), scales.T, strict=True):
            self.register_buffer(name, column.clone(), persistent=False)

    def forward(self, observed: Tensor) -> tuple[Tensor, Tensor]:
        """Return the weight g of each area, and 1 where g has an effect; else both are zero.

        It has one if the robot and its partner both hold an estimate of the area.
        """
        told = {name: observed[:, each] for name, each in self._columns.items()}
        both = {name: told[name].expand(-1, 2) for name in ("frames", "range")}
        elsewhere = {"own_p_elsewhere": told["own_p"].flip(1)}
        seen = {**told, **both, **elsewhere, **self._remembered(observed)}
        shown = torch.stack([seen[name] for name in self.architecture.features], 2)
        x = (torch.log1p(shown / self.unit) - self.centre) / self.spread
        w, direct = self.arrays, self.arrays["direct.weight"]
        hidden = torch.tanh(dense_layer(w, "hidden", x))
        ahead = told["own_p"] - told["heard_p"]
        network = x @ direct[:-1] + hidden @ w["output.weight"] + w["output.bias"]
        asked = self._asked(told)
        return torch.sigmoid((1.0 + direct[-1]) * ahead + network) * asked, asked

    def _remembered(self, observed: Tensor) -> dict[str, Tensor]:
        """What is not observed in the encounter: nothing."""
        return {}

    def _asked(self, told: Mapping[str, Tensor]) -> Tensor:
        """1 for each area of which both robots hold an estimate."""
        return told["own_known"] * told["heard_known"]


class ReputationActor(WeightingActor):
    """The actor of `training.learned_weighting`.

    It sees an encounter, and then what is remembered of one area.
    """

    architecture = REPUTATION_NETWORK
    network = architecture.name

    def _remembered(self, observed: Tensor) -> dict[str, Tensor]:
        """What is remembered, alike for both areas."""
        columns = observed[:, -len(REMEMBERED) :].T
        return {
            name: column[:, None].expand(-1, 2)
            for name, column in zip(REMEMBERED, columns, strict=True)
        }

    def _asked(self, told: Mapping[str, Tensor]) -> Tensor:
        """1 for each area that the partner told of."""
        return told["heard_known"]


class WeightingCritic(NamedNetwork):
    """The critic of a learned weighting: the state value; a constant without an exchange."""

    def __init__(self, layout: FieldLayout) -> None:
        """Make a network for observations of this layout."""
        self._columns = layout.columns("encounter")
        n = max(each.stop for each in self._columns.values())
        shapes = {"first.weight": (32, n), "first.bias": (32,)}
        super().__init__({**shapes, "value.weight": (1, 32), "value.bias": (1,)}, "value", 1.0)

    def forward(self, observed: Tensor) -> Tensor:
        """Return the state value of each row."""
        arrays = self.arrays
        hidden = torch.tanh(dense_layer(arrays, "first", torch.log1p(observed)))
        return dense_layer(arrays, "value", hidden)


ACTORS: Mapping[LayerName, type[WeightingActor | MotionActor]] = {
    "weighting": WeightingActor,
    "motion": MotionActor,
}
CRITICS: Mapping[LayerName, type[WeightingCritic | MotionCritic]] = {
    "weighting": WeightingCritic,
    "motion": MotionCritic,
}


class LayerPolicy(nn.Module):
    """The actors of all learned layers, one critic, and Gaussian noise: what PPO trains."""

    def __init__(self, layout: FieldLayout, layers: tuple[LayerName, ...], log_std: float) -> None:
        """Make new networks; actions are those of the layers in this order."""
        super().__init__()
        self.actors = nn.ModuleDict({layer: ACTORS[layer](layout) for layer in layers})
        self.critic = CRITICS[layers[-1]](layout)
        n_actions = sum(len(action_features(layer)) for layer in layers)
        self.log_std = nn.Parameter(torch.full((n_actions,), log_std))

    def forward(self, observed: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Draw actions; return them, the state values and the log probability of each row."""
        gaussian = self.distribution(observed)
        actions = gaussian.rsample()
        return actions, self.critic(observed), _log_probs(gaussian, actions)

    def evaluate_actions(self, observed: Tensor, actions: Tensor) -> tuple[Tensor, Tensor, None]:
        """Return the state values and the log probabilities of actions; the entropy is left out."""
        log_probs = _log_probs(self.distribution(observed), actions)
        return self.critic(observed), log_probs, None

    def predict_values(self, observed: Tensor) -> Tensor:
        """Return the state value of each row."""
        return cast(Tensor, self.critic(observed))

    def distribution(self, observed: Tensor) -> Normal:
        """Distribution of all actions; of those without effect it depends on no parameter."""
        outputs = [actor(observed) for actor in self.actors.values()]
        means, effects = (torch.cat(each, 1) for each in zip(*outputs, strict=True))
        log_std = torch.where(effects > 0.0, self.log_std, LOG_STD_WITHOUT_EFFECT)
        return Normal(means, log_std.exp(), validate_args=False)


def _log_probs(gaussian: Normal, actions: Tensor) -> Tensor:
    return cast(Tensor, gaussian.log_prob(actions).sum(1))  # type: ignore[no-untyped-call]
