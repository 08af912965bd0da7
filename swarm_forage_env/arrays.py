"""Array types with named axes.

The axes: `rows` are robots, N consecutive rows per world; `slots` hold messages;
`words` are the values in a message; the axis of length 2 named `areas` is (nest, prey).
"""

from jaxtyping import Bool, Float32, Float64, Int8, Int32, Int64, UInt8, UInt64
from numpy import ndarray as Array  # noqa: N812 the name in jaxtyping

__all__ = [
    "NEST", "PREY", "Array", "Bool", "Float32", "Float64", "Int8", "Int32", "Int64", "UInt8",
    "UInt64", "read_only",
]  # fmt: skip

NEST = 0
"""Index of the nest on the axis `areas`."""

PREY = 1
"""Index of the prey area on the axis `areas`."""


def read_only(array: Array) -> Array:
    """Return a view of an array that cannot be written to."""
    view = array.view()
    view.flags.writeable = False
    return view
