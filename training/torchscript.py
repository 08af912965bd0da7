"""Saving of other trainers' networks as TorchScript with a card, for `torchscript:policy.pt`."""

import io
import warnings
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor, nn

from swarm_forage_env.errors import ConfigError
from training.policy_card import PolicyCard
from training.policy_file import write_both

TOLERANCE = 1e-4
"""Largest accepted difference between the actions of the policy and of the saved network."""


class _Rows(nn.Module):
    """Network for any number of robots that calls a network for n robots, n rows at a time."""

    def __init__(self, network: Callable[[Tensor], Tensor], n: int) -> None:
        super().__init__()
        self.network, self.n = network, n

    def forward(self, observed: Tensor) -> Tensor:
        """Return the actions of the robots, a row for each."""
        n_missing = -observed.shape[0] % self.n
        padded = torch.cat([observed, torch.zeros([n_missing, observed.shape[1]])])
        actions = [self.network(part) for part in torch.split(padded, self.n)]
        return torch.cat(actions)[: observed.shape[0]]


@torch.no_grad()
def save_torchscript(
    act: Callable[[Tensor], Tensor], n_robots: int, card: PolicyCard, file: str | Path
) -> Path:
    """Save a function from observations of n robots, (robots, features), to their actions.

    ConfigError unless it is the same for every robot and uses the robot's own observation alone.
    """
    path = Path(file)
    generator = torch.Generator().manual_seed(0)
    first, others = torch.rand(2, n_robots, len(card.observes), generator=generator) * 2.0 - 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about constants in a trace; outputs are compared below
        try:
            traced = torch.jit.trace(act, (first,), check_trace=False)  # type: ignore[no-untyped-call]
            script = torch.jit.script(_Rows(traced, n_robots))
            content = io.BytesIO()
            torch.jit.save(script, content)
        except RuntimeError as error:
            why = str(error).strip().partition("\n")[0]
            raise ConfigError(f"policy {path}: cannot be saved as TorchScript ({why})") from None
    mixed = torch.cat([others[:-1], first[:1]])
    alike = [(act(others), script(others)), (act(first)[:1], act(mixed)[-1:])]
    for wanted, scripted in alike:
        if not torch.allclose(wanted.float(), scripted.float(), atol=TOLERANCE):
            raise ConfigError(
                f"policy {path}: cannot be saved as TorchScript, as its actions depend on more"
                " than what the robot observes itself"
            )
    path.parent.mkdir(parents=True, exist_ok=True)
    write_both(path, content.getvalue(), card)
    return path
