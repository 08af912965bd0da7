"""Energy that a GPU has used, as the library of its driver (NVML) tells it."""

import ctypes
from collections.abc import Callable
from typing import Any

LIBRARY = "libnvidia-ml.so.1"


def energy_meter(uuid: str, library: Any = None) -> Callable[[], float] | None:  # noqa: ANN401 a library, or one of a test
    """What tells the energy [J] that the GPU of this UUID has used since its driver was loaded.

    None where the driver does not tell it: another system, or a GPU older than Volta.
    """
    try:
        nvml = library or ctypes.CDLL(LIBRARY)
    except OSError:
        return None
    gpu, used = ctypes.c_void_p(), ctypes.c_ulonglong()

    def read() -> bool:
        return bool(nvml.nvmlDeviceGetTotalEnergyConsumption(gpu, ctypes.byref(used)) == 0)

    is_found = (
        nvml.nvmlInit_v2() == 0
        and nvml.nvmlDeviceGetHandleByUUID(uuid.encode(), ctypes.byref(gpu)) == 0
    )
    if not is_found or not read():
        return None

    def joules() -> float:
        read()
        return used.value / 1e3

    return joules
