"""TensorVecEnv: all learners of blocks of worlds as rows of tensors, on a CPU or a GPU.

Tensors share the memory of the worlds' arrays, except in numba's simulator.
"""

import json
import time
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple, cast

import numpy as np
import torch
from gymnasium.spaces import Box
from torch import Tensor

from swarm_forage_env.compiler import is_simulated
from swarm_forage_env.device_memory import usable_gpu
from swarm_forage_env.envs.actions import as_array
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.episodes import checked_seeds
from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.observed_fields import FieldLayout
from swarm_forage_env.worlds_on_cpu import Device, checked_device


class Step(NamedTuple):
    """Result of one decision of all rows."""

    observations: Tensor
    """Observations, (rows, features); after a reset, the first ones of the new episode."""
    rewards: Tensor
    """Reward of each row, in single precision."""
    final_observations: Tensor
    """As `observations`, but the last ones of an episode that ended."""
    ended: Tensor
    """True for rows whose episode ended."""


class _DeviceBuffers:
    """Fixed arrays for the inputs and outputs of a block on a GPU, with tensors on their memory."""

    def __init__(self, block: ArrayEnv) -> None:
        self._block, self._outputs = block, block.output_arrays()
        shape = block.n_worlds, len(block.learners), *block.action_shape
        self._action_array = block.memory.empty(shape, block.action_space.dtype)
        self._actions = tensor_of(self._action_array)
        rewards, _, observations, over = self._outputs  # observations: at the end, after resets
        self._results = tensor_of(rewards[1]), tensor_of(observations), tensor_of(over)

    def launch(self, actions: Tensor) -> Step:
        """Launch one decision of the block."""
        self._actions.copy_(actions.view_as(self._actions))
        self._block.launch(self._action_array, self._outputs)
        rewards, both, over = self._results  # shaped rewards; where an episode is over
        rows = over[:, None].expand(rewards.shape)
        final, observations = both.flatten(1, 2)
        return Step(observations, rewards.float().flatten(), final, rows.flatten())


class TensorVecEnv:
    """Environment of all learners of blocks of worlds, one row each, by block and by world.

        env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=4096, physics="kinematic")])
        env.seed(0)
        observations = env.reset()
        step = env.step(actions)

    The blocks have the same observations, actions and device, on which all tensors stay. A world is
    reset as soon as its episode ends. `stepping_s` is the wall-clock time of all steps [s]; on a
    GPU, only that of launching them.
    """

    def __init__(self, blocks: Sequence[ArrayEnv]) -> None:
        """Join blocks with any numbers of worlds and robots; ConfigError if no policy fits all."""
        self.blocks = list(blocks)
        first = self.blocks[0]
        wanted = _form_of(first)
        for k, block in enumerate(self.blocks[1:], start=1):
            for name, own in _form_of(block).items():
                if own != wanted[name]:
                    raise ConfigError(
                        f"block {k}: has {name}={shown(own)}, and block 0 {shown(wanted[name])}; a"
                        " policy of all blocks needs the same"
                    )
        self.device = torch_device(first.device)
        self.observation_space, self.action_space = first.observation_space, first.action_space
        self.observation_layout = cast(FieldLayout, first.observation_layout)
        self._n_rows = [len(each.learners) * each.n_worlds for each in self.blocks]
        self.n_rows: int = sum(self._n_rows)
        self.stepping_s = 0.0
        self.acts = torch.ones(self.n_rows, dtype=torch.bool, device=self.device)
        """True for rows whose next action counts: all, except under `step_on="exchange"`."""

    @property
    def action_bounds(self) -> tuple[Tensor, Tensor]:
        """Lower and upper bounds of the actions; ConfigError if actions are choices."""
        space = self.action_space
        if not isinstance(space, Box):
            raise ConfigError("discrete: PPO in tensors gives continuous actions; leave it out")
        return tensor_of(space.low).to(self.device), tensor_of(space.high).to(self.device)

    @property
    def is_one_launch(self) -> bool:
        """Whether a step is one GPU launch for each block: `count`, then `launch`, which a CUDA
        graph can repeat."""
        return all(each.is_one_launch for each in self.blocks)

    @cached_property
    def _standing(self) -> list[_DeviceBuffers]:
        return [_DeviceBuffers(each) for each in self.blocks]

    @property
    def robot_steps(self) -> int:
        """Robot-steps of the learners of all worlds since the blocks were made."""
        return sum(each.robot_steps for each in self.blocks)

    def seed(self, *seeds: int) -> None:
        """Seed the sequences from which resets draw the seeds of the worlds, as in `SwarmVecEnv`.

        Each of several seeds applies to an equal part of the worlds of every block, as if alone.
        """
        for block in self.blocks:
            n, rest = divmod(block.n_worlds, len(seeds))
            if rest:
                raise ConfigError(f"seeds {seeds}: must divide {block.n_worlds} worlds equally")
            block.episodes.seed([own for each in seeds for own in checked_seeds(each, n)])

    def check_shares(self, n: int, together: int) -> None:
        """Raise ConfigError unless rows form n equal parts, each of whole groups of `together`."""
        first, subject = self.blocks[0], f"{n} policies side by side"
        if together < 1 or self.n_rows // n % together:
            raise ConfigError(
                f"rows_together={together}: must divide the {self.n_rows // n} rows of a policy;"
                " use the number of robots of a world"
            )
        if n == 1:
            return
        if len(self.blocks) > 1 or first.n_worlds % n:
            raise ConfigError(
                f"{subject}: need equal parts of the worlds of one scenario; use one scenario, and"
                f" a multiple of {n} worlds"
            )
        if first.config.step_on == "exchange":
            raise ConfigError(f"{subject}: must act in every step; leave step_on='exchange' out")

    def reset(self) -> Tensor:
        """Reset all worlds and return the observation of every row."""
        self._follow_stream()
        observations, infos = zip(*(block.reset() for block in self.blocks), strict=True)
        self._update_acts([each.get("acts") for each in infos])
        return _rows(observations)

    def step(self, actions: Tensor) -> Step:
        """Step all rows. ConfigError for actions out of bounds, which on a GPU `check` raises."""
        shape = self.n_rows, *self.blocks[0].action_shape
        if actions.shape != shape:
            raise ConfigError(f"actions of shape {tuple(actions.shape)}: must be {shape}")
        begin = time.perf_counter()
        if self.is_one_launch:
            self.count()
            step = self.launch(actions)
        else:
            step = self._step_each(actions)
        self.stepping_s += time.perf_counter() - begin
        return step

    def count(self) -> None:
        """Run the CPU's part of a step that is one launch for each block."""
        self._follow_stream()
        for block in self.blocks:
            block.count_step()

    def launch(self, actions: Tensor) -> Step:
        """Run the GPU's part of such a step, on fixed tensors and without waiting for a value."""
        shares = torch.split(actions, self._n_rows)
        steps = [each.launch(share) for each, share in zip(self._standing, shares, strict=True)]
        return Step(*map(torch.cat, zip(*steps, strict=True)))

    def check(self) -> None:
        """Wait for the GPU. ConfigError if it has refused an action since the last check."""
        self._follow_stream()
        for block in self.blocks:
            block.check()

    def _update_acts(self, acts: Sequence[object]) -> None:
        if acts[0] is not None:
            self.acts = torch.cat([tensor_of(each).flatten() for each in acts]) > 0.0

    def _step_each(self, actions: Tensor) -> Step:
        """Step every block by its environment."""
        self._follow_stream()
        steps, ended = [], []
        for block, share in zip(self.blocks, torch.split(actions, self._n_rows), strict=True):
            shaped = share.reshape(block.n_worlds, len(block.learners), *block.action_shape)
            steps.append(block.step_and_reset(array_for(block, shaped)))
            ended.append(np.repeat(steps[-1].is_over, len(block.learners)))
        self._update_acts([each.acts for each in steps])
        rows = torch.from_numpy(np.concatenate(ended)).to(self.device)
        rewards = torch.cat([tensor_of(each.rewards).float().flatten() for each in steps])
        final, observations = ([each[k] for each in steps] for k in range(2))
        return Step(_rows(observations), rewards, _rows(final), rows)

    def _follow_stream(self) -> None:
        for block in self.blocks:
            follow_stream(block)


def _form_of(block: ArrayEnv) -> dict[str, object]:
    """Return what a policy fits: its keywords, observed features and device."""
    own = {"features": [*block.observation_layout.names], "device": block.device}
    return {**json.loads(block.card)["keywords"], **own}


def _rows(observations: Sequence[object]) -> Tensor:
    return torch.cat([tensor_of(each).flatten(0, 1) for each in observations])


FIRST_GPU = 0  # index of the GPU that worlds run on


def torch_device(device: str) -> torch.device:
    """Return the torch device whose memory holds the worlds of a device, "cpu" or "cuda".

    ConfigError for another device, and for a GPU that is missing or that torch cannot use. The
    worlds of numba's simulator are in the CPU's memory.
    """
    checked_device(device)
    if device == "cpu":
        return torch.device("cpu")
    usable_gpu()
    if is_simulated():
        return torch.device("cpu")
    if not torch.cuda.is_available():
        raise ConfigError(
            f"device='cuda': torch {torch.__version__} finds no GPU; install its build for CUDA,"
            " or use device='cpu'"
        )
    return torch.device("cuda")


def worlds_on(device: torch.device | str) -> Device:
    """Return the device of worlds for tensors on a torch device. ConfigError for a second GPU."""
    wanted = torch.device(device)
    if wanted.type != "cuda":
        return "cpu"
    if wanted.index:
        raise ConfigError(
            f"device='{wanted}': worlds run on the first GPU; set"
            f" CUDA_VISIBLE_DEVICES={wanted.index}, and use device='cuda'"
        )
    return "cuda"


def follow_stream(env: ArrayEnv) -> None:
    """Run worlds on a GPU in the order of torch's current stream from now on."""
    if env.device == "cuda" and torch.cuda.is_initialized():  # type: ignore[no-untyped-call]
        env.stream = torch.cuda.current_stream(FIRST_GPU).cuda_stream


def tensor_of(array: object) -> Tensor:
    """Return a tensor over the memory of an array."""
    if hasattr(array, "__cuda_array_interface__"):
        return torch.as_tensor(array, device="cuda")
    return torch.from_numpy(np.ascontiguousarray(array))


def array_for(env: ArrayEnv, tensor: Tensor) -> object:
    """Return an array over the memory of a tensor, for the environment's `step`."""
    dense = tensor.detach().contiguous()
    if env.device == "cpu":
        return as_array(dense.cpu())
    return dense if dense.is_cuda else env.memory.to_device(dense.numpy())
