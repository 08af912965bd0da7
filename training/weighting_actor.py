"""The networks of learned weightings in PyTorch, to be fitted to recorded exchanges."""

import torch
from torch import Tensor, nn

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.observed_fields import FieldLayout
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    HIDDEN,
    REMEMBERED,
    REPUTATION_NETWORK,
    WeightingNetwork,
)
from training.policy_file import Weights

GAIN = 0.01  # of the orthogonal initialisation of the last layer: its output starts near zero


class WeightingActor(nn.Module):
    """The network of `training.learned_weighting`, with the names and shapes of a policy file."""

    unit: Tensor
    centre: Tensor
    spread: Tensor

    def __init__(
        self,
        layout: FieldLayout,
        hidden: int = HIDDEN,
        architecture: WeightingNetwork = EXCHANGE_NETWORK,
    ) -> None:
        """Make a network for observations of this layout, with `hidden` hidden units.

        Matrices are orthogonal, the last one with a gain of its own; biases are zero.
        """
        super().__init__()
        self.architecture, self.sizes = architecture, {"hidden": hidden}
        for name, shape in architecture.shapes(self.sizes).items():
            layer, _, array = name.partition(".")
            if layer not in dict(self.named_children()):
                self.add_module(layer, nn.Module())
            parameter = nn.Parameter(torch.zeros(shape))
            if len(shape) > 1:
                nn.init.orthogonal_(parameter, GAIN if layer == "output" else 2.0**0.5)
            self.get_submodule(layer).register_parameter(array, parameter)
        self._columns = layout.columns("encounter")
        scales = torch.tensor(architecture.scales)
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

    def forward(self, observed: Tensor) -> Tensor:
        """Return the weight g of each area; 0 where the network is not asked for one.

        It is asked about areas that both robots know; if it sees what is remembered, about all
        areas that the partner told of.
        """
        exchange = {name: observed[:, each] for name, each in self._columns.items()}
        seen = {**exchange, "own_p_elsewhere": exchange["own_p"].flip(1)}
        seen |= {name: exchange[name].expand(-1, 2) for name in ("frames", "range")}
        asked = exchange["heard_known"]
        if self.architecture is REPUTATION_NETWORK:
            remembered = observed[:, -len(REMEMBERED) :].T[:, :, None].expand(-1, -1, 2)
            seen |= zip(REMEMBERED, remembered, strict=True)
        else:
            asked = asked * exchange["own_known"]
        features = torch.stack([seen[name] for name in self.architecture.features], 2)
        x = (torch.log1p(features / self.unit) - self.centre) / self.spread
        w, direct = self.arrays, self.arrays["direct.weight"]
        hidden = torch.tanh(x @ w["hidden.weight"].T + w["hidden.bias"])
        ahead = exchange["own_p"] - exchange["heard_p"]
        network = x @ direct[:-1] + hidden @ w["output.weight"] + w["output.bias"]
        return torch.sigmoid((1.0 + direct[-1]) * ahead + network) * asked
