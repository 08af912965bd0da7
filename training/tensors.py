"""Tensors of torch over the arrays of an environment: on a CPU, on a GPU, in numba's simulator.

Nothing is copied, but where a tensor goes into the simulator.
"""

from typing import Any

import numpy as np
import torch
from torch import Tensor

from swarm_forage_env.compiler import is_simulated
from swarm_forage_env.device_memory import usable_gpu
from swarm_forage_env.envs.device_env import DeviceArrayEnv, check_device
from swarm_forage_env.errors import ConfigError

ON_CPU = torch.device("cpu")

FIRST_GPU = 0
"""The number of the GPU that worlds run on."""


def torch_device(device: str) -> torch.device:
    """Where torch finds the numbers of worlds on a device, "cpu" or "cuda".

    ConfigError for another device, and for a GPU that is missing or that torch cannot use. The
    worlds of numba's simulator are in the CPU's memory.
    """
    check_device(device)
    if device == "cpu":
        return ON_CPU
    usable_gpu()
    if is_simulated():
        return ON_CPU
    if not torch.cuda.is_available():
        raise ConfigError(
            f"device='cuda': torch {torch.__version__} finds no GPU; install its build for CUDA,"
            " or take device='cpu'"
        )
    return torch.device("cuda")


def worlds_on(device: torch.device | str) -> str:
    """Where worlds run whose tensors are on a device of torch: on a GPU if that is "cuda".

    ConfigError for a second GPU.
    """
    wanted = torch.device(device)
    if wanted.type == "cuda" and wanted.index:
        raise ConfigError(
            f"device='{wanted}': worlds run on the first GPU; set CUDA_VISIBLE_DEVICES="
            f"{wanted.index}, and take device='cuda'"
        )
    return "cuda" if wanted.type == "cuda" else "cpu"


def follow_stream(env: Any) -> None:  # noqa: ANN401 an ArrayEnv, or one of a GPU
    """Let worlds on a GPU run in the order of torch's current stream from now on."""
    if isinstance(env, DeviceArrayEnv) and torch.cuda.is_initialized():  # type: ignore[no-untyped-call]
        env.stream = torch.cuda.current_stream(FIRST_GPU).cuda_stream


def tensor_of(array: Any) -> Tensor:  # noqa: ANN401 of NumPy or of a GPU
    """The tensor in the place of an array, on its device."""
    if hasattr(array, "__cuda_array_interface__"):
        return torch.as_tensor(array, device="cuda")
    return torch.from_numpy(np.ascontiguousarray(array))


def array_for(env: Any, tensor: Tensor) -> Any:  # noqa: ANN401 an ArrayEnv, or one of a GPU
    """The array in the place of a tensor, as the environment's `step` takes it."""
    given = tensor.detach().contiguous()
    if not isinstance(env, DeviceArrayEnv):
        return given.numpy(force=True)
    return given if given.is_cuda else env.loop.memory.to_device(given.numpy())
