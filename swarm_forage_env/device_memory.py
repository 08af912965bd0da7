"""Arrays in the memory of a GPU, and the stream in whose order they are copied and worked on."""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import gpu
from swarm_forage_env.errors import ConfigError

Grid = tuple[int, tuple[int, int]]
"""Blocks, and threads of a block: robots by worlds."""


class DeviceMemory:
    """The memory of a GPU: every copy and every kernel is in the order of one stream."""

    def __init__(self) -> None:
        """Of the first GPU, in CUDA's default stream; ConfigError where there is none."""
        self._gpu = usable_gpu()
        self._address = 0
        self._stream: Any = 0

    @property
    def stream(self) -> int:
        """The address of the stream; 0 is CUDA's default stream."""
        return self._address

    def change_stream(self, address: Any) -> None:  # noqa: ANN401 whatever was given
        """Go on in the stream of an address, after what the one before was asked to do.

        ConfigError for what is no address.
        """
        if not isinstance(address, int) or isinstance(address, bool) or address < 0:
            raise ConfigError(
                f"stream={address!r}: must be the address of a stream of CUDA, as"
                " torch.cuda.current_stream().cuda_stream; or 0, the default stream"
            )
        if address == self._address:
            return
        done = self.mark()
        self._address = address
        self._stream = self._gpu.external_stream(address) if address else 0
        done.wait(self._stream)

    def launch(self, grid: Grid) -> tuple[Any, ...]:
        """What a kernel is launched on: a grid, and the stream."""
        return *grid, self._stream

    def mark(self) -> Any:  # noqa: ANN401 an event of the GPU
        """A moment in what the GPU does, from which another can be timed by `elapsed_time` [ms]."""
        event = self._gpu.event()
        event.record(self._stream)
        return event

    def to_device(self, array: Array) -> Any:  # noqa: ANN401 an array of the GPU
        """A copy of an array in the memory of the GPU."""
        return self._gpu.to_device(np.ascontiguousarray(array), stream=self._stream)

    def empty(self, shape: tuple[int, ...], dtype: Any) -> Any:  # noqa: ANN401 as above
        """An array in the memory of the GPU."""
        return self._gpu.device_array(shape, dtype, stream=self._stream)

    def write(self, there: Any, array: Array) -> None:  # noqa: ANN401 as above
        """Copy an array into one of the GPU."""
        there.copy_to_device(np.ascontiguousarray(array), stream=self._stream)

    def read(self, there: Any) -> Array:  # noqa: ANN401 as above
        """A copy of an array of the GPU in the memory of the CPU: waits for the GPU."""
        found: Array = there.copy_to_host(stream=self._stream)
        return found

    def lend(self, there: Any) -> Any:  # noqa: ANN401 as above
        """An array to be given out, which whoever gets it must let be."""
        return there

    def taken(self, given: Any) -> Any:  # noqa: ANN401 a tensor of any library
        """An array of any library on the same GPU, without a copy; ConfigError for another."""
        is_numba = hasattr(given, "__cuda_ndarray__")
        if not is_numba and not hasattr(given, "__cuda_array_interface__"):
            raise ConfigError(
                f"{type(given).__name__}: must be an array of the GPU, one that has"
                " __cuda_array_interface__, as a torch tensor after .to('cuda')"
            )
        return given if is_numba else self._gpu.as_cuda_array(given)


def usable_gpu() -> Any:  # noqa: ANN401 numba's module for GPUs
    """What moves arrays to a GPU; ConfigError where there is none."""
    found = gpu()
    if not found.is_available():
        raise ConfigError("device='cuda': no NVIDIA GPU with its driver found; take device='cpu'")
    return found
