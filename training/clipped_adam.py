"""Adam on networks of several policies, the gradient of each of which is clipped as a whole."""

from collections.abc import Sequence

import torch
from torch import Tensor, nn

MAX_GRADIENT_NORM = 0.5
"""Clipping of the gradient: as SB3."""

EPSILON = 1e-5
"""Of Adam's denominator: as SB3."""

MOMENTS = ("exp_avg", "exp_avg_sq")
"""Entries of Adam's state for each parameter, beside its number of steps."""


class ClippedAdam:
    """Adam with clipping; on a GPU its steps can be a part of a graph.

    Numbers of a parameter are equal parts, one for each policy in turn.
    """

    def __init__(self, networks: nn.Module, n_policies: int, rate: float) -> None:
        """Moments are zeros."""
        self._parameters, self._n_policies = list(networks.parameters()), n_policies
        device = self._parameters[0].device
        on_gpu = device.type == "cuda"
        usable = torch.tensor(rate, device=device) if on_gpu else rate
        self._adam = torch.optim.Adam(
            self._parameters, usable, eps=EPSILON, fused=on_gpu or None, capturable=on_gpu
        )
        self.steps = [torch.zeros((), device=device) for _ in self._parameters]
        """How many were taken, for each parameter."""
        self.tensors: dict[str, Sequence[Tensor]] = {"policy": self._parameters}
        """By name those for each parameter: itself, and its moments."""
        for name in MOMENTS:
            self.tensors[name] = [torch.zeros_like(each) for each in self._parameters]
        columns = zip(self.steps, *self.tensors.values(), strict=True)
        for step, parameter, *moments in columns:
            named = dict(zip(MOMENTS, moments, strict=True))
            self._adam.state[parameter] = {"step": step, **named}

    def descend(self, outputs: Sequence[Tensor], along: Sequence[Tensor]) -> None:
        """Take a step along gradients of losses by outputs of the networks."""
        gradients = torch.autograd.grad(outputs, self._parameters, along)
        of_policies = [each.reshape(self._n_policies, -1) for each in gradients]
        norms = torch.cat(of_policies, 1).norm(dim=1, keepdim=True)
        scale = torch.clamp(MAX_GRADIENT_NORM / (norms + 1e-6), max=1.0)
        for parameter, gradient in zip(self._parameters, of_policies, strict=True):
            parameter.grad = (gradient * scale).view_as(parameter)
        self._adam.step()
