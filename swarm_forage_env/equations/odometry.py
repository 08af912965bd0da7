"""What the wheel encoders tell: the path of the wheels, misread a little."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.random_draws import Streams, symmetric


@kernel
def encoder(dU: float, error: float, streams: Streams, column: int) -> float:
    """The path of a wheel as its encoder tells it [m], for a true path dU [m].

        dU + e,  e uniform in +- error

    error is a share of the greatest path of a tick [m]; a wheel at rest is read exactly.

    Source: ANTS, Section 4.1.
    """
    return dU + error * symmetric(streams, column) if dU != 0.0 else 0.0
