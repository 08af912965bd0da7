"""Kernels of social odometry, part two: talking to a neighbour and merging what it told.

A message says for each area: known (1 or 0), distance [m], direction in the sender's body
frame [rad], p [m].
"""

import math

from baselines.estimators.beliefs import NOBODY, NOWHERE
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import range_and_bearing, wrap

WORDS_PER_AREA = 4


@kernel
def heard_location(
    D: float, gamma_i: float, gamma_j: float, d_j: float, phi_j: float
) -> tuple[float, float]:
    """Where the sender's area is for the receiver, body frame [m].

        alpha = phi_j - gamma_j
        phi_i = gamma_i + alpha - pi
        X = D cos gamma_i + d_j cos phi_i
        Y = D sin gamma_i + d_j sin phi_i

    D is the measured range [m]; gamma_i, gamma_j the bearings of the beam at the receiver and
    at the sender; d_j, phi_j the sender's distance [m] and direction to the area, body frame of
    the sender [rad]. The TR prints d_i, which must be the transmitted d_j, as in ANTS.

    Source: TR, Eq. 40; ANTS, Section 4.2.
    """
    phi_i = gamma_i + (phi_j - gamma_j) - math.pi
    return (
        D * math.cos(gamma_i) + d_j * math.cos(phi_i),
        D * math.sin(gamma_i) + d_j * math.sin(phi_i),
    )


@kernel
def recently_met(
    sender: int, met: Int32[Array, " memory"], met_for: Int32[Array, " memory"]
) -> bool:
    """The sender was talked to not long ago."""
    known = False
    for k in range(met.shape[0]):
        known |= met[k] == sender and met_for[k] > 0
    return known


@kernel
def remember(
    sender: int, ticks: int, met: Int32[Array, " memory"], met_for: Int32[Array, " memory"]
) -> None:
    """Put a partner in the place of the one whose time runs out first, in place."""
    k = 0
    for other in range(1, met.shape[0]):
        if met_for[other] < met_for[k]:
            k = other
    met[k] = sender
    met_for[k] = ticks


@kernel
def is_useful(
    words: Float32[Array, " words"],
    known: Bool[Array, " areas"],
    p: Float64[Array, " areas"],
    goal: int,
    double: bool,
    listens_above: float,
) -> bool:
    """The message tells of an area that is unknown here, headed for or, if double, of any.

    Of one that is known, only if the own p is at least `listens_above` [m].
    """
    for area in range(2):
        told = words[area * WORDS_PER_AREA] > 0.0
        if told and not known[area]:
            return True
        if told and (double or area == goal) and p[area] >= listens_above:
            return True
    return False


@kernel
def note(  # noqa: PLR0913 inputs first, then what is updated
    words: Float32[Array, " words"],
    beam: Float32[Array, " beam"],
    weight: float,
    message_path: float,
    pose: Float64[Array, "3"],
    heard_sum: Float64[Array, "areas 2"],
    heard_weight: Float64[Array, " areas"],
    heard_p: Float64[Array, " areas"],
) -> None:
    """Add one message to the running means of a conversation, in the receiver's own frame.

    What is heard counts as if its sender had gone `message_path` farther [m].
    """
    theta = pose[2]
    for area in range(2):
        at = area * WORDS_PER_AREA
        if words[at] > 0.0:
            ahead, left = heard_location(beam[0], beam[1], beam[2], words[at + 1], words[at + 2])
            c, s = math.cos(theta), math.sin(theta)
            heard_sum[area, 0] += weight * (pose[0] + c * ahead - s * left)
            heard_sum[area, 1] += weight * (pose[1] + s * ahead + c * left)
            heard_weight[area] += weight
            heard_p[area] = words[at + 3] + message_path


@kernel
def slot_of(valid: Bool[Array, " slots"], sender: Int32[Array, " slots"], wanted: int) -> int:
    """The slot that holds a message of that sender, or the number of slots."""
    for slot in range(valid.shape[0]):
        if valid[slot] and sender[slot] == wanted:
            return slot
    return int(valid.shape[0])


@kernel
def find_partner(  # noqa: PLR0913 one row of many arrays
    valid: Bool[Array, " slots"],
    sender: Int32[Array, " slots"],
    words: Float32[Array, "slots words"],
    known: Bool[Array, " areas"],
    p: Float64[Array, " areas"],
    goal: int,
    double: bool,
    listens_above: float,
    met: Int32[Array, " memory"],
    met_for: Int32[Array, " memory"],
) -> int:
    """The first sender worth talking to, NOBODY if there is none."""
    for slot in range(valid.shape[0]):
        fresh = valid[slot] and not recently_met(sender[slot], met, met_for)
        if fresh and is_useful(words[slot], known, p, goal, double, listens_above):
            return int(sender[slot])
    return NOBODY


@kernel
def converse(  # noqa: PLR0913 inputs first, then what is updated
    valid: Bool[Array, "rows slots"],
    sender: Int32[Array, "rows slots"],
    words: Float32[Array, "rows slots words"],
    beam: Float32[Array, "rows slots beam"],
    frames: Int32[Array, "rows slots"],
    parameters: Array,
    pose: Float64[Array, "rows 3"],
    known: Bool[Array, "rows areas"],
    p: Float64[Array, "rows areas"],
    goal: Int8[Array, " rows"],
    deaf: Int32[Array, " rows"],
    partner: Int32[Array, " rows"],
    talk_left: Int32[Array, " rows"],
    heard_sum: Float64[Array, "rows areas 2"],
    heard_weight: Float64[Array, "rows areas"],
    heard_p: Float64[Array, "rows areas"],
    range_sum: Float64[Array, " rows"],
    frames_sum: Float64[Array, " rows"],
    met: Int32[Array, "rows memory"],
    met_for: Int32[Array, "rows memory"],
    out_ended: Bool[Array, " rows"],
) -> int:
    """Start, go on with and end conversations; how many ended, and in which rows.

    A conversation starts with the first useful message of a robot not met recently, lasts a
    fixed time, averages what that robot says in it, and then closes to that robot for a while.
    """
    double = parameters[0]["double"] > 0.0
    message_path = float(parameters[0]["message_path"])
    listens_above = float(parameters[0]["listens_above"])
    n_ended = 0
    for i in range(pose.shape[0]):
        out_ended[i] = False
        for k in range(met_for.shape[1]):
            met_for[i, k] = max(met_for[i, k] - 1, 0)
        if partner[i] == NOBODY:
            if deaf[i] > 0:
                continue
            partner[i] = find_partner(
                valid[i], sender[i], words[i], known[i], p[i], goal[i], double, listens_above,
                met[i], met_for[i],
            )  # fmt: skip
            if partner[i] == NOBODY:
                continue
            talk_left[i] = int(parameters[0]["talk_ticks"])
            heard_sum[i, :, :] = 0.0
            heard_weight[i, :] = 0.0
            range_sum[i] = 0.0
            frames_sum[i] = 0.0
        slot = slot_of(valid[i], sender[i], partner[i])
        if slot < valid.shape[1]:
            weight = float(frames[i, slot])
            note(
                words[i, slot], beam[i, slot], weight, message_path, pose[i],
                heard_sum[i], heard_weight[i], heard_p[i],
            )  # fmt: skip
            range_sum[i] += weight * beam[i, slot, 0]
            frames_sum[i] += weight
        if talk_left[i] == 0:
            remember(partner[i], int(parameters[0]["refractory_ticks"]), met[i], met_for[i])
            partner[i] = NOBODY
            deaf[i] = int(parameters[0]["pause_ticks"])
            out_ended[i] = True
            n_ended += 1
        talk_left[i] -= 1
    return n_ended


@kernel
def merge(  # noqa: PLR0913 inputs first, then what is updated
    ended: Bool[Array, " rows"],
    g: Float32[Array, "rows areas"],
    heard_p_share: float,
    double: bool,
    goal: Int8[Array, " rows"],
    heard_sum: Float64[Array, "rows areas 2"],
    heard_weight: Float64[Array, "rows areas"],
    heard_p: Float64[Array, "rows areas"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
) -> None:
    """Copy what was unknown; blend what both know, about the goal (single) or both (double).

        x_i = (1 - g) x_i + g X_j
        p_i = (1 - g) p_i + share g p_j

    Source: TR, Eq. 14, 34, 35, 38 and 39.
    """
    for i in range(p.shape[0]):
        if not ended[i]:
            continue
        for area in range(2):
            if heard_weight[i, area] == 0.0:
                continue
            x = heard_sum[i, area, 0] / heard_weight[i, area]
            y = heard_sum[i, area, 1] / heard_weight[i, area]
            if not known[i, area]:
                known[i, area] = True
                location[i, area, 0], location[i, area, 1] = x, y
                p[i, area] = heard_p[i, area]
            elif double or area == goal[i]:
                w = float(g[i, area])
                location[i, area, 0] = (1.0 - w) * location[i, area, 0] + w * x
                location[i, area, 1] = (1.0 - w) * location[i, area, 1] + w * y
                p[i, area] = (1.0 - w) * p[i, area] + heard_p_share * w * heard_p[i, area]


@kernel
def speak(  # noqa: PLR0913 inputs first, then the outputs
    double: bool,
    tells_within: float,
    pose: Float64[Array, "rows 3"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
    goal: Int8[Array, " rows"],
    out_words: Float32[Array, "rows words"],
    out_speaking: Bool[Array, " rows"],
) -> None:
    """Tell of every known area; who knows both, only of one whose p is at most `tells_within`.

    A single filter on its way tells only where it comes from.
    """
    out_words[:] = 0.0
    for i in range(p.shape[0]):
        out_speaking[i] = False
        on_the_way = not double and known[i, 0] and known[i, 1] and goal[i] != NOWHERE
        for area in range(2):
            unsure = known[i, 1 - area] and p[i, area] > tells_within
            if not known[i, area] or unsure or (on_the_way and area == goal[i]):
                continue
            dx, dy = location[i, area, 0] - pose[i, 0], location[i, area, 1] - pose[i, 1]
            distance, direction = range_and_bearing(dx, dy, pose[i, 2])
            at = area * WORDS_PER_AREA
            out_words[i, at] = 1.0
            out_words[i, at + 1] = distance
            out_words[i, at + 2] = wrap(direction)
            out_words[i, at + 3] = p[i, area]
            out_speaking[i] = True
