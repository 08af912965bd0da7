"""The networks of the learned layers as stable-baselines3 trains them, one tower for each layer.

Where a layer's action has no effect (a weight without an exchange, the wheels of a robot that
is talking), the policy does what the running layer does, almost without noise and whatever its
parameters are: such steps teach the actor nothing, and disturb nothing.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, cast

import torch
from stable_baselines3.common.distributions import DiagGaussianDistribution, Distribution
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import Schedule
from torch import Tensor, nn

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.layout import ObservationLayout
from training.motion import NETWORK, SIZES, columns_of, dense, motion_shapes, pooled, wheels_of
from training.policy import LayerName, Shapes

STILL = -5.0
"""Logarithm of the standard deviation of an action without effect."""

GAIN = 0.01
"""Of the first weights of an actor's last layer: it starts near zero."""


class Tower(nn.Module):
    """Named dense layers; the names and shapes are those of a policy's file."""

    network: ClassVar[str]
    """What kind of network, and its sizes, as a card says."""
    sizes: ClassVar[Mapping[str, int]]

    def __init__(self, shapes: Shapes, last: str, gain: float) -> None:
        """Orthogonal weights, those of the last layer with another gain, and no biases."""
        super().__init__()
        for name, shape in shapes.items():
            layer, _, array = name.partition(".")
            if array == "weight":
                made = nn.Linear(shape[1], shape[0])
                nn.init.orthogonal_(made.weight, gain if layer == last else 2.0**0.5)
                nn.init.zeros_(made.bias)
                self.add_module(layer, made)

    @property
    def arrays(self) -> dict[str, Tensor]:
        """The weights and biases by name."""
        return dict(self.named_parameters())

    def as_in_file(self) -> dict[str, Float32[Array, "..."]]:
        """The weights and biases as a policy's file has them."""
        return {name: array.detach().numpy().copy() for name, array in self.arrays.items()}


class MotionTower(Tower):
    """The network of `training.motion`."""

    network = NETWORK
    sizes = SIZES

    def __init__(self, layout: ObservationLayout) -> None:
        """For observations of a layout."""
        super().__init__(motion_shapes(SIZES), "wheels", GAIN)
        self._columns = columns_of(layout, "situation")

    def forward(self, observed: Tensor) -> tuple[Tensor, Tensor]:
        """The wheels, and 1 where they have an effect."""
        moves = 1.0 - observed[:, self._columns["talking"]]
        wheels = wheels_of(self.arrays, observed, self._columns, torch)
        return wheels * moves, moves.expand(-1, 2)


class MotionValue(Tower):
    """What a situation is worth, by a network of the same form."""

    def __init__(self, layout: ObservationLayout) -> None:
        """For observations of a layout."""
        shapes = dict(motion_shapes(SIZES))
        shapes["value.weight"] = (1, shapes.pop("wheels.weight")[1])
        super().__init__(shapes, "value", 1.0)
        self._columns = columns_of(layout, "situation")

    def forward(self, observed: Tensor) -> Tensor:
        """The value of each row."""
        arrays = self.arrays
        hidden = torch.tanh(dense(arrays, "first", pooled(arrays, observed, self._columns, torch)))
        return cast(Tensor, dense(arrays, "value", torch.tanh(dense(arrays, "second", hidden))))


ACTORS: Mapping[LayerName, Any] = {"motion": MotionTower}
CRITICS: Mapping[LayerName, Any] = {"motion": MotionValue}


class Towers(nn.Module):
    """The actors of all learned layers side by side, and one critic."""

    def __init__(self, layout: ObservationLayout, layers: tuple[LayerName, ...]) -> None:
        """Layers in the order of their actions; the last one's critic is that of all."""
        super().__init__()
        self.actors = nn.ModuleDict({layer: ACTORS[layer](layout) for layer in layers})
        self.critic = CRITICS[layers[-1]](layout)

    def forward(self, observed: Tensor) -> tuple[Tensor, Tensor]:
        """What the actor and what the critic make of the observations."""
        return self.forward_actor(observed), self.forward_critic(observed)

    def forward_actor(self, observed: Tensor) -> Tensor:
        """All actions, then for each 1 where it has an effect."""
        means, effects = zip(*(actor(observed) for actor in self.actors.values()), strict=True)
        return torch.cat([*means, *effects], 1)

    def forward_critic(self, observed: Tensor) -> Tensor:
        """The value of each row."""
        return cast(Tensor, self.critic(observed))


class LayersPolicy(ActorCriticPolicy):
    """The policy of SB3's PPO that acts in the place of one layer or of several."""

    def __init__(
        self,
        *spaces: Any,  # noqa: ANN401 spaces and schedule, as SB3 passes them
        layout: ObservationLayout,
        layers: tuple[LayerName, ...],
        **options: Any,  # noqa: ANN401 those of SB3
    ) -> None:
        """For observations of a layout."""
        self._layout = layout
        self._layers = layers
        super().__init__(*spaces, **options)

    def _build(self, lr_schedule: Schedule) -> None:
        self.mlp_extractor = Towers(self._layout, self._layers)  # type: ignore[assignment]
        self.action_net = nn.Identity()
        self.value_net = nn.Identity()  # type: ignore[assignment]
        size = self.action_space.shape or (0,)
        self.log_std = nn.Parameter(torch.full(size, self.log_std_init))
        self.optimizer = torch.optim.Adam(self.parameters(), lr_schedule(1), eps=1e-5)

    def _get_action_dist_from_latent(self, latent_pi: Tensor) -> Distribution:
        means, effects = latent_pi.chunk(2, dim=1)
        log_std = torch.where(effects > 0.0, self.log_std, STILL)
        gaussian = cast(DiagGaussianDistribution, self.action_dist)
        return gaussian.proba_distribution(means, log_std)
