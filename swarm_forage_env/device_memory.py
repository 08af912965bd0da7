"""Arrays in the memory of a GPU, and the stream in whose order they are copied and worked on."""

from types import ModuleType
from typing import Any, cast

import numpy as np
from numpy.typing import DTypeLike

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import gpu
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.worlds_on_cpu import Memory, PlacedArray

Grid = tuple[int, tuple[int, int]]
"""Blocks, and threads of a block: robots by worlds."""


class DeviceMemory(Memory):
    """The memory of a GPU: every copy and every kernel is in the order of one stream."""

    def __init__(self) -> None:
        self._gpu = usable_gpu()
        self._stream: object = 0

    def change_stream(self, address: object) -> None:
        """Go on in the stream of an address, after the one before; ConfigError for no address."""
        if not isinstance(address, int) or isinstance(address, bool) or address < 0:
            raise ConfigError(
                f"stream={address!r}: must be the address of a stream of CUDA, as"
                " torch.cuda.current_stream().cuda_stream; or 0, the default stream"
            )
        if address == self.stream:
            return
        done = self.mark()
        self.stream = address
        self._stream = self._gpu.external_stream(address) if address else 0
        done.wait(self._stream)

    def launch(self, grid: Grid) -> tuple[object, ...]:
        """What a kernel is launched on: a grid, and the stream."""
        return *grid, self._stream

    def mark(self) -> Any:  # noqa: ANN401 an event of the GPU
        """A moment in what the GPU does, from which another can be timed by `elapsed_time` [ms]."""
        event = self._gpu.event()
        event.record(self._stream)
        return event

    def to_device(self, array: Array) -> Any:  # noqa: ANN401 an array of numba's, on a GPU
        """A copy of an array in the memory of the GPU."""
        return self._gpu.to_device(np.ascontiguousarray(array), stream=self._stream)

    def repeated(self, array: Array) -> Any:  # noqa: ANN401 as above
        """As `to_device`, of an array whose rows are as the first: no other leaves the CPU."""
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
        """An array in the memory of the GPU."""
        return self._gpu.device_array(shape, dtype, stream=self._stream)

    def write(self, there: Any, array: Array) -> None:  # noqa: ANN401 as above
        """Copy an array into one of the GPU."""
        there.copy_to_device(np.ascontiguousarray(array), stream=self._stream)

    def read(self, there: Any) -> Array:  # noqa: ANN401 as above
        """A copy of an array of the GPU in the memory of the CPU: waits for the GPU."""
        array: Array = there.copy_to_host(stream=self._stream)
        return array

    def lend(self, there: PlacedArray) -> PlacedArray:
        """An array to be handed out, which its receiver must not write to."""
        return there

    def as_device_array(self, tensor: object) -> PlacedArray:
        """An array of any library on the same GPU, without a copy; ConfigError for another."""
        if hasattr(tensor, "__cuda_ndarray__"):
            return cast(PlacedArray, tensor)
        if not hasattr(tensor, "__cuda_array_interface__"):
            raise ConfigError(
                f"{type(tensor).__name__}: must be an array of the GPU, one that has"
                " __cuda_array_interface__, as a torch tensor after .to('cuda')"
            )
        return cast(PlacedArray, self._gpu.as_cuda_array(tensor))


def usable_gpu() -> ModuleType:
    """The module of numba for GPUs; ConfigError where there is no GPU."""
    cuda = gpu()
    if not cuda.is_available():
        raise ConfigError("device='cuda': no NVIDIA GPU with its driver found; take device='cpu'")
    return cuda
