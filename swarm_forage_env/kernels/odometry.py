"""What the wheel encoders tell: the path of the wheels, misread a little."""

from swarm_forage_env.arrays import Array, Float32, Float64, UInt64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.diff_drive import wheels_to_arc
from swarm_forage_env.kernels.rng import symmetric


@kernel
def encoder(dU: float, error: float, streams: UInt64[Array, " rows"], i: int) -> float:
    """The path of a wheel as its encoder tells it [m], for a true path dU [m].

        dU + e,  e uniform in +- error

    error is a share of the greatest path of a tick [m]; a wheel at rest is read exactly.

    Source: ANTS, Section 4.1.
    """
    return dU + error * symmetric(streams, i) if dU != 0.0 else 0.0


@kernel
def read_odometry(
    wheels: Float64[Array, "rows 2"],
    dt: float,
    axle: float,
    error: float,
    streams: UInt64[Array, " rows"],
    out_reading: Float32[Array, "rows 2"],
) -> None:
    """Distance [m] and turn [rad] of each robot in a tick of dt [s], from noisy encoders."""
    for i in range(wheels.shape[0]):
        dU_l = encoder(wheels[i, 0] * dt, error, streams, i)
        dU_r = encoder(wheels[i, 1] * dt, error, streams, i)
        out_reading[i, 0], out_reading[i, 1] = wheels_to_arc(dU_l, dU_r, axle)
