"""The networks of learned weightings in PyTorch, to be fitted to recorded exchanges."""

from collections.abc import Mapping

import torch
from torch import Tensor, nn

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.observed_fields import FieldLayout
from training.learned_weighting import EXCHANGE_NETWORK, HIDDEN, REMEMBERED, REPUTATION_NETWORK
from training.policy_file import Weights

GAIN = 0.01
"""Gain of the orthogonal initialisation of the last layer: its output starts near zero."""


class WeightingActor(nn.Module):
    """The network of `training.learned_weighting`, with the names and shapes of a policy file."""

    architecture = EXCHANGE_NETWORK
    network = architecture.name
    """Name of the architecture on a policy card."""
    unit: Tensor
    centre: Tensor
    spread: Tensor

    def __init__(self, layout: FieldLayout, hidden: int = HIDDEN) -> None:
        """Make a network for observations of this layout, with `hidden` hidden units.

        Matrices are orthogonal, the last one with a gain of its own; biases are zero.
        """
        super().__init__()
        self.sizes = {"hidden": hidden}
        for name, shape in self.architecture.shapes(self.sizes).items():
            layer, _, array = name.partition(".")
            if layer not in dict(self.named_children()):
                self.add_module(layer, nn.Module())
            made = nn.Parameter(torch.zeros(shape))
            if len(shape) > 1:
                nn.init.orthogonal_(made, GAIN if layer == "output" else 2.0**0.5)
            self.get_submodule(layer).register_parameter(array, made)
        self._columns = layout.columns("encounter")
        scales = torch.tensor(self.architecture.scales)
        for name, column in zip(("unit", "centre", "spread"), scales.T, strict=True):
            self.register_buffer(name, column.clone(), persistent=False)

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
        hidden = torch.tanh(x @ w["hidden.weight"].T + w["hidden.bias"])
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
