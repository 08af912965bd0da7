"""Arrays in the memory of a GPU, and the CUDA stream that orders copies and kernels."""

from types import ModuleType
from typing import Any, cast

import numpy as np
from numpy.typing import DTypeLike

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import gpu
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.worlds_on_cpu import Memory, PlacedArray

Grid = tuple[int, tuple[int, int]]
"""Number of blocks, and threads of a block (robots, worlds)."""


class DeviceMemory(Memory):
    """Memory of a GPU; every copy and every kernel runs in one stream."""

    def __init__(self) -> None:
        self._gpu = usable_gpu()
        self._stream: object = 0

    def change_stream(self, address: object) -> None:
        """Continue in the stream of this address, after the current one; ConfigError if invalid."""
        if not isinstance(address, int) or isinstance(address, bool) or address < 0:
            raise ConfigError(
                f"stream={address!r}: must be the address of a CUDA stream, such as"
                " torch.cuda.current_stream().cuda_stream, or 0 for the default stream"
            )
        if address == self.stream:
            return
        done = self.mark()
        self.stream = address
        self._stream = self._gpu.external_stream(address) if address else 0
        done.wait(self._stream)

    def launch(self, grid: Grid) -> tuple[object, ...]:
        """Return the launch configuration of a kernel: a grid, and the stream."""
        return *grid, self._stream

    def mark(self) -> Any:  # noqa: ANN401 an event of the GPU
        """Record an event in the stream; `elapsed_time` gives the time between two events [ms]."""
        event = self._gpu.event()
        event.record(self._stream)
        return event

    def to_device(self, array: Array) -> Any:  # noqa: ANN401 an array of numba's, on a GPU
        """Return a copy of an array in GPU memory."""
        return self._gpu.to_device(np.ascontiguousarray(array), stream=self._stream)

    def repeated(self, array: Array) -> Any:  # noqa: ANN401 as above
        """Copy an array with equal rows to the GPU, transferring only the first row."""
        if not array.size:
            return self.to_device(array)
        there, size, done = self.empty(array.shape, array.dtype), array.nbytes, array[:1].nbytes
        self.write(there[:1], array[:1])
        flat = there.view(np.uint8).reshape(size)
        while done < size:
            more = min(done, size - done)
            flat[done : done + more].copy_to_device(flat[:more], stream=self._stream)
            done += more
        return there

    def empty(self, shape: tuple[int, ...], dtype: DTypeLike) -> Any:  # noqa: ANN401 as above
        """Return a new array in GPU memory."""
        return self._gpu.device_array(shape, dtype, stream=self._stream)

    def write(self, there: Any, array: Array) -> None:  # noqa: ANN401 as above
        """Copy an array into an array on the GPU."""
        there.copy_to_device(np.ascontiguousarray(array), stream=self._stream)

    def read(self, there: Any) -> Array:  # noqa: ANN401 as above
        """Return a copy of a GPU array in the memory of the CPU; this waits for the GPU."""
        array: Array = there.copy_to_host(stream=self._stream)
        return array

    def lend(self, there: PlacedArray) -> PlacedArray:
        """Return the array itself, for reading only."""
        return there

    def as_device_array(self, tensor: object) -> PlacedArray:
        """Return a view of any library's array on this GPU; ConfigError for another array."""
        if hasattr(tensor, "__cuda_ndarray__"):
            return cast(PlacedArray, tensor)
        if not hasattr(tensor, "__cuda_array_interface__"):
            raise ConfigError(
                f"{type(tensor).__name__}: must be an array in GPU memory that has"
                " __cuda_array_interface__, such as a torch tensor after .to('cuda')"
            )
        return cast(PlacedArray, self._gpu.as_cuda_array(tensor))


def usable_gpu() -> ModuleType:
    """Return numba's module for GPUs; ConfigError if there is no GPU."""
    cuda = gpu()
    if not cuda.is_available():
        raise ConfigError("device='cuda': no NVIDIA GPU with its driver found; use device='cpu'")
    return cuda
