"""The range-and-bearing radio: who is heard, and how well the beam is measured."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int32, UInt64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import range_and_bearing, wrap
from swarm_forage_env.kernels.rng import below, normal, symmetric, unit

POWER_GAP = np.array([0.0, 0.02, 0.05, 0.10, 0.15, 0.30, 0.45, 0.60])
POWER_MU = np.array([7.647, 7.597, 7.250, 7.085, 6.984, 6.917, 6.823, 6.829])
POWER_SIGMA = np.array([0.357, 0.319, 0.193, 0.153, 0.109, 0.122, 0.153, 0.142])
"""Received power of the real board is lognormal; mu and sigma by the gap between bodies [m].

Source: ARGoS3-epuck, range-and-bearing noise of the real board.
"""


@kernel
def loss(d: float, near: float, far: float, loss_near: float, loss_far: float) -> float:
    """Probability that a message over distance d [m] is lost: linear from near to far.

    Source: TR, Section 6.1; ANTS, Section 4.1.
    """
    along = min(max((d - near) / (far - near), 0.0), 1.0)
    return loss_near + (loss_far - loss_near) * along


@kernel
def mean_error(streams: UInt64[Array, " rows"], i: int, frames: int, amplitude: float) -> float:
    """Mean of the errors of some frames, each uniform in +- amplitude."""
    total = 0.0
    for _ in range(frames):
        total += symmetric(streams, i)
    return amplitude * total / frames


@kernel
def board_range(gap: float, streams: UInt64[Array, " rows"], i: int) -> float:
    """The gap [m] that one frame of the real board measures for a true gap [m].

        power = exp(mu + sigma z),  100 gap = exp(9.06422 - 0.00565075 power)

    z is standard normal; mu and sigma are interpolated linearly in the gap.

    Source: ARGoS3-epuck, range-and-bearing noise of the real board.
    """
    mu = np.interp(gap, POWER_GAP, POWER_MU)
    sigma = np.interp(gap, POWER_GAP, POWER_SIGMA)
    power = math.exp(mu + sigma * normal(streams, i))
    return 0.01 * math.exp(9.06422 - 0.00565075 * power)


@kernel
def mean_board_range(gap: float, streams: UInt64[Array, " rows"], i: int, frames: int) -> float:
    """Mean of the gaps [m] that some frames of the real board measure."""
    total = 0.0
    for _ in range(frames):
        total += board_range(gap, streams, i)
    return total / frames


@kernel
def deliver(  # noqa: PLR0913 inputs first, then the outputs
    pose: Float64[Array, "rows 3"],
    pairs: Int32[Array, "capacity 2"],
    n_pairs: int,
    speaking: Bool[Array, " rows"],
    radio: Array,
    loss_streams: UInt64[Array, " rows"],
    slot_streams: UInt64[Array, " rows"],
    out_sender: Int32[Array, "rows slots"],
    out_count: Int32[Array, " rows"],
) -> None:
    """Which messages arrive: out_sender names rows, out_count how many reached each row.

    Of more messages than slots, each is equally likely to be heard (reservoir sampling).
    """
    n_slots = out_sender.shape[1]
    out_count[:] = 0
    far = radio[0]["max_range"]
    for k in range(n_pairs):
        for side in range(2):
            i, j = pairs[k, side], pairs[k, 1 - side]
            if not speaking[j]:
                continue
            d = math.hypot(pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1])
            if d > far:
                continue
            lost = loss(d, radio[0]["near"], far, radio[0]["loss_near"], radio[0]["loss_far"])
            if unit(loss_streams, i) < lost:
                continue
            slot = out_count[i]
            if slot >= n_slots:
                slot = below(slot_streams, i, out_count[i] + 1)
            out_count[i] += 1
            if slot < n_slots:
                out_sender[i, slot] = j


@kernel
def measure(  # noqa: PLR0913 inputs first, then the outputs
    pose: Float64[Array, "rows 3"],
    wheels: Float64[Array, "rows 2"],
    sender: Int32[Array, "rows slots"],
    count: Int32[Array, " rows"],
    radio: Array,
    is_board: bool,
    diameter: float,
    streams: UInt64[Array, " rows"],
    out_beam: Float32[Array, "rows slots 3"],
    out_frames: Int32[Array, "rows slots"],
) -> None:
    """Range [m], bearing and bearing back [rad] of every message that arrived, with noise.

    A receiver at rest averages radio.frames frames, a moving one has a single frame.
    """
    bearing_noise = radio[0]["bearing_noise"]
    for i in range(pose.shape[0]):
        at_rest = wheels[i, 0] == 0.0 and wheels[i, 1] == 0.0
        frames = int(radio[0]["frames"]) if at_rest else 1
        for slot in range(sender.shape[1]):
            heard = slot < count[i]
            out_frames[i, slot] = frames if heard else 0
            out_beam[i, slot, :] = 0.0
            if not heard:
                continue
            j = sender[i, slot]
            dx, dy = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
            d, bearing = range_and_bearing(dx, dy, pose[i, 2])
            _, back = range_and_bearing(-dx, -dy, pose[j, 2])
            if is_board:
                gap = max(d - diameter, 0.0)
                out_beam[i, slot, 0] = diameter + mean_board_range(gap, streams, i, frames)
            else:
                error = mean_error(streams, i, frames, radio[0]["range_noise"])
                out_beam[i, slot, 0] = max(d + error, 0.0)
            out_beam[i, slot, 1] = wrap(bearing + mean_error(streams, i, frames, bearing_noise))
            out_beam[i, slot, 2] = wrap(back + mean_error(streams, i, frames, bearing_noise))


@kernel
def hand_over(  # noqa: PLR0913 inputs first, then the outputs
    sender: Int32[Array, "rows slots"],
    count: Int32[Array, " rows"],
    words: Float32[Array, "rows words"],
    n_robots: int,
    out_valid: Bool[Array, "rows slots"],
    out_sender: Int32[Array, "rows slots"],
    out_words: Float32[Array, "rows slots words"],
    out_messages: Int32[Array, " rows"],
) -> None:
    """Copy the words that arrived to their slots; empty slots hold zeros. Counts messages."""
    for i in range(sender.shape[0]):
        for slot in range(sender.shape[1]):
            heard = slot < count[i]
            out_valid[i, slot] = heard
            out_messages[i] += heard
            j = sender[i, slot]
            out_sender[i, slot] = j % n_robots if heard else 0
            for word in range(words.shape[1]):
                out_words[i, slot, word] = words[j, word] if heard else 0.0
