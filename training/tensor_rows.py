"""TensorRows: all learners of blocks of worlds as rows of tensors, on a CPU or a GPU."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.device_env import DeviceArrayEnv
from swarm_forage_env.envs.episodes import checked_seeds
from swarm_forage_env.observed_fields import FieldLayout
from training.policy_file import arrays_under
from training.tensors import array_for, follow_stream, tensor_of, torch_device


@dataclass(frozen=True)
class Step:
    """What a decision of all rows leads to."""

    seen: Tensor
    """Observations, rows by numbers; of a world that started anew, those of its start."""
    rewards: Tensor
    """In single precision, one for each row."""
    final: Tensor
    """Observations, of a world whose episode ended those of its end."""
    over: Tensor
    """Numbers of the rows whose episodes ended."""


class TensorRows:
    """The learners of blocks of worlds, block after block and world after world, one row each.

        rows = TensorRows([array_env("es1", device="cuda", n_worlds=4096, physics="kinematic")])
        rows.seed(0)
        seen = rows.reset()
        step = rows.step(actions)

    The blocks observe and act alike, and are on one device, on which all tensors stay. A world
    whose episode ends starts anew at once. `stepping_s` is the wall time of all steps [s].
    """

    def __init__(self, blocks: Sequence[Any]) -> None:
        """Rows of these blocks: each an `ArrayEnv` or a `DeviceArrayEnv`."""
        self.blocks = list(blocks)
        first = self.blocks[0]
        self.device = torch_device("cuda" if isinstance(first, DeviceArrayEnv) else "cpu")
        self.observation_space, self.action_space = first.observation_space, first.action_space
        self.observation_layout: FieldLayout = first.observation_layout
        self._n_learners = [len(each.learners) for each in self.blocks]
        self._n_rows = [n * each.n_worlds for n, each in self._of_blocks()]
        self.n_rows: int = sum(self._n_rows)
        self.stepping_s = 0.0

    def seed(self, seed: int) -> None:
        """Seed the sequences from which resets draw the seeds of the worlds, as `SwarmVecEnv`."""
        for block in self.blocks:
            episodes = host_of(block).episodes
            for world, own in enumerate(checked_seeds(seed, block.n_worlds)):
                episodes.generators[world] = np.random.default_rng(own)

    def reset(self) -> Tensor:
        """Start all worlds anew; what every row observes."""
        self._follow_stream()
        return self._joined([tensor_of(block.reset()[0]) for block in self.blocks])

    def step(self, actions: Tensor) -> Step:
        """One decision of all rows; ConfigError for an action that is out of bounds."""
        begin = time.perf_counter()
        self._follow_stream()
        told, final, rewards = [], [], []
        over: list[Bool[Array, " rows"]] = []
        shares = torch.split(actions, self._n_rows)
        for (n_learners, block), own in zip(self._of_blocks(), shares, strict=True):
            given = own.reshape(block.n_worlds, n_learners, *host_of(block).action_shape)
            seen, earned, *_ = block.step(array_for(block, given))
            final.append(tensor_of(seen))
            rewards.append(tensor_of(earned).float().flatten())
            over.append(np.repeat(block.is_over, n_learners))
            if block.is_over.any():
                seen, _ = block.reset(worlds=block.is_over)
            told.append(tensor_of(seen))
        ended = torch.from_numpy(np.flatnonzero(np.concatenate(over))).to(self.device)
        self.stepping_s += time.perf_counter() - begin
        return Step(self._joined(told), torch.cat(rewards), self._joined(final), ended)

    def records(self) -> dict[str, Array]:
        """All that the next steps of blocks on a GPU depend on, as `DeviceArrayEnv.records`."""
        return {
            f"{k}.{name}": array
            for k, block in enumerate(self.blocks)
            for name, array in block.records().items()
        }

    def take_records(self, records: Mapping[str, Array]) -> None:
        """Go on as when `records` of rows of the same blocks gave them."""
        for k, block in enumerate(self.blocks):
            block.take_records(arrays_under(f"{k}.", records))

    def _follow_stream(self) -> None:
        """Run in the order of torch's current stream."""
        for block in self.blocks:
            follow_stream(block)

    def _of_blocks(self) -> Iterator[tuple[int, Any]]:
        """How many learners a world has, and the block, of each block."""
        return zip(self._n_learners, self.blocks, strict=True)

    def _joined(self, observations: Sequence[Tensor]) -> Tensor:
        """Observations of all blocks, a row for each learner."""
        return torch.cat([each.flatten(0, 1) for each in observations])


def host_of(block: Any) -> ArrayEnv:  # noqa: ANN401 an ArrayEnv, or one of a GPU
    """The environment on the CPU with the names and the episodes of a block."""
    return block.host if isinstance(block, DeviceArrayEnv) else block
