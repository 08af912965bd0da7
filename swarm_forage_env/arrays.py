"""Array types with named axes, checked in tests and free otherwise.

The axes: `rows` are robots, N consecutive ones to a world; `slots` hold messages;
`words` are the numbers in a message; the axis of length 2 named `areas` is (nest, prey).
"""

import os
from collections.abc import Callable
from typing import TypeVar

from jaxtyping import Bool, Float32, Float64, Int8, Int32, Int64, UInt8, UInt64, jaxtyped
from numpy import ndarray as Array  # noqa: N812 the word of jaxtyping

__all__ = [
    "NEST", "PREY", "Array", "Bool", "Float32", "Float64", "Int8", "Int32", "Int64", "UInt8",
    "UInt64", "checked",
]  # fmt: skip

NEST = 0
"""Index of the nest on the axis `areas`."""

PREY = 1
"""Index of the prey area on the axis `areas`."""

CheckedT = TypeVar("CheckedT", bound=Callable[..., object])


def checked(target: CheckedT) -> CheckedT:
    """Check shapes and dtypes at each call when SWARM_CHECK_SHAPES is set; free otherwise.

    The outermost decorator of a dataclass or function.
    """
    if not os.environ.get("SWARM_CHECK_SHAPES"):
        return target
    from beartype import beartype

    return jaxtyped(typechecker=beartype)(target)
