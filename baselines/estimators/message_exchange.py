"""Message exchange of social odometry: talking to one neighbour, and merging its estimates.

Gutierrez et al. 2009 (TR), Sections 4.1, 4.3 and 5.2.
"""

import math

from baselines.estimators.area_memory import displacement_to
from baselines.estimators.belief import NOBODY, NOWHERE, Belief, Message, SocialMind
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Heard
from swarm_forage_env.equations.elementary import cos, cos_sin, sin
from swarm_forage_env.equations.geometry import range_and_bearing, wrap
from swarm_forage_env.record import Numbers

DISTANCE_RANGE, P_RANGE = 8.192, 131.072
"""Limits just above the largest distance and p that an integer word can hold [m]."""


@kernel
def heard_location(
    D: float, gamma_i: float, gamma_j: float, d_j: float, phi_j: float
) -> tuple[float, float]:
    """Return the location of the sender's area in the body frame of the receiver [m].

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
    return D * cos(gamma_i) + d_j * cos(phi_i), D * sin(gamma_i) + d_j * sin(phi_i)


@kernel
def heard_place(belief: Belief, area: int) -> tuple[float, float]:
    """Return the mean of the locations of an area heard in the exchange, own frame [m]."""
    place, weight = belief.heard_sum[area], belief.heard_weight[area]
    return place[0] / weight, place[1] / weight


@kernel
def is_listening(mind: SocialMind) -> bool:
    """Return whether the robot may read messages in this tick; call it before the countdown."""
    return mind.belief.partner != NOBODY or mind.belief.ignore_ticks <= 1


@kernel
def was_recently_met(belief: Belief, sender: int) -> bool:
    """Return whether the sender was a partner within the time `refractory`."""
    for k in range(belief.recent_partners.shape[0]):
        if belief.recent_partners[k] == sender and belief.recent_ticks_left[k] > 0:
            return True
    return False


@kernel
def remember_partner(belief: Belief, ticks: int) -> None:
    """Store the partner over the remembered one whose time ends first."""
    k = 0
    for other in range(1, belief.recent_partners.shape[0]):
        if belief.recent_ticks_left[other] < belief.recent_ticks_left[k]:
            k = other
    belief.recent_partners[k] = belief.partner
    belief.recent_ticks_left[k] = ticks


@kernel
def may_merge(belief: Belief, area: int, numbers: Numbers) -> bool:
    """Return whether the robot merges the area: it is unknown, the goal or, if double, any."""
    return not belief.known[area] or numbers.double > 0.0 or area == belief.goal


@kernel
def is_useful(belief: Belief, message: Message, numbers: Numbers) -> bool:
    """Return whether the message has an estimate of an unknown area, or of one that may be merged
    and whose own p is at least `listens_above` [m]."""
    for area in range(2):
        is_unsure = not belief.known[area] or belief.p[area] >= numbers.listens_above
        if message.has_estimate[area] and is_unsure and may_merge(belief, area, numbers):
            return True
    return False


@kernel
def find_partner(minds: Array, i: int, heard: Heard, numbers: Numbers) -> int:
    """Return the first sender of a useful message that was not met recently, or NOBODY."""
    belief = minds[i].belief
    for slot in range(heard.n):
        sender = heard.sender[slot]
        is_fresh = not was_recently_met(belief, sender)
        if is_fresh and is_useful(belief, minds[sender].message, numbers):
            return int(sender)
    return NOBODY


@kernel
def slot_of(heard: Heard, sender: int) -> int:
    """Return the slot with a message of the sender; without one, the number of messages."""
    for slot in range(heard.n):
        if heard.sender[slot] == sender:
            return slot
    return int(heard.n)


@kernel
def accumulate_message(
    belief: Belief, message: Message, beam: Float32[Array, "3"], weight: float, message_path: float
) -> None:
    """Add one message to the running sums of an exchange, in the receiver's own frame.

    The beam is the sender's range [m], its bearing and the bearing back [rad]; the weight is the
    number of frames averaged in it. `message_path` is added to the heard p [m].
    """
    c, s = cos_sin(belief.pose[2])
    for area in range(2):
        if message.has_estimate[area]:
            ahead, left = heard_location(
                beam[0], beam[1], beam[2], message.distance[area], message.direction[area]
            )
            belief.heard_sum[area, 0] += weight * (belief.pose[0] + c * ahead - s * left)
            belief.heard_sum[area, 1] += weight * (belief.pose[1] + s * ahead + c * left)
            belief.heard_weight[area] += weight
            belief.heard_p[area] = message.p[area] + message_path
    belief.range_sum += weight * beam[0]
    belief.n_averaged += weight


@kernel
def has_partner(minds: Array, i: int, heard: Heard, numbers: Numbers) -> bool:
    """Count down the recent partners; start an exchange if possible; return whether one is open."""
    belief = minds[i].belief
    for k in range(belief.recent_ticks_left.shape[0]):
        belief.recent_ticks_left[k] = max(belief.recent_ticks_left[k] - 1, 0)
    if belief.partner == NOBODY:
        if belief.ignore_ticks > 0 or heard.n == 0:
            return False
        belief.partner = find_partner(minds, i, heard, numbers)
        if belief.partner == NOBODY:
            return False
        belief.last_partner = belief.partner
        belief.exchange_ticks_left = int(numbers.talk_ticks)
        belief.range_sum, belief.n_averaged = 0.0, 0.0
        for area in range(2):
            belief.heard_sum[area, 0] = belief.heard_sum[area, 1] = 0.0
            belief.heard_weight[area] = 0.0
    return True


@kernel
def end_in_time(belief: Belief, numbers: Numbers) -> bool:
    """End the exchange if its time is over, and start the pauses; return whether it ended."""
    has_ended = bool(belief.exchange_ticks_left == 0)
    if has_ended:
        remember_partner(belief, int(numbers.refractory_ticks))
        belief.partner = NOBODY
        belief.ignore_ticks = int(numbers.pause_ticks)
    belief.exchange_ticks_left -= 1
    return has_ended


@kernel
def update_exchange(minds: Array, i: int, heard: Heard, numbers: Numbers) -> bool:
    """Start, continue or end the exchange of robot i; return whether it ended in this tick."""
    if not has_partner(minds, i, heard, numbers):
        return False
    belief = minds[i].belief
    slot = slot_of(heard, belief.partner)
    if slot < heard.n:
        beam, weight = heard.range_bearing[slot], float(heard.n_averaged[slot])
        message = minds[belief.partner].message
        accumulate_message(belief, message, beam, weight, numbers.message_path)
    return end_in_time(belief, numbers)


@kernel
def merge_area(belief: Belief, area: int, g: float, heard_p_share: float) -> None:
    """Copy the heard estimate of an unknown area; blend that of a known area.

        x_i = (1 - g) x_i + g X_j
        p_i = (1 - g) p_i + share g p_j

    Source: TR, Eq. 14, 34, 35, 38 and 39.
    """
    place, (x, y) = belief.location[area], heard_place(belief, area)
    if belief.known[area]:
        place[0], place[1] = (1.0 - g) * place[0] + g * x, (1.0 - g) * place[1] + g * y
        belief.p[area] = (1.0 - g) * belief.p[area] + heard_p_share * g * belief.heard_p[area]
    else:
        belief.known[area] = True
        place[0], place[1] = x, y
        belief.p[area] = belief.heard_p[area]


@kernel
def is_merged(belief: Belief, area: int, numbers: Numbers) -> bool:
    """Return whether the partner sent an estimate of the area that the robot merges."""
    return belief.heard_weight[area] != 0.0 and may_merge(belief, area, numbers)


@kernel
def merge(mind: SocialMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Merge the heard estimates of both areas into the own ones, with the exchange's weights."""
    for area in range(2):
        if is_merged(mind.belief, area, numbers):
            merge_area(mind.belief, area, float(mind.exchange.weight[area]), heard_p_share)


@kernel
def sends_estimate(belief: Belief, area: int, numbers: Numbers) -> bool:
    """Return whether the robot sends its estimate of the area: known and, if `first_hand`, visited.

    A robot that knows both areas sends one only while its p is at most `tells_within`; a robot with
    a single filter and a goal does not send the goal.

    Source: TR, Section 4.1, before Eq. 14, for `first_hand`; TR, Section 6.1.2.
    """
    if numbers.speaks == 0.0 or not belief.known[area]:
        return False
    if numbers.first_hand > 0.0 and not belief.visited[area]:
        return False
    if not belief.known[1 - area]:
        return True
    is_on_its_way = numbers.double == 0.0 and belief.goal != NOWHERE
    return belief.p[area] <= numbers.tells_within and not (is_on_its_way and area == belief.goal)


@kernel
def has_something_to_say(mind: SocialMind, numbers: Numbers) -> bool:
    """Return whether the robot broadcasts: it has an estimate to send."""
    return sends_estimate(mind.belief, 0, numbers) or sends_estimate(mind.belief, 1, numbers)


@kernel
def write_estimate(belief: Belief, area: int, message: Message) -> None:
    """Write distance, direction and p of an area to the message."""
    dx, dy = displacement_to(belief, area)
    distance, direction = range_and_bearing(dx, dy, belief.pose[2])
    message.distance[area], message.direction[area] = distance, direction
    message.p[area] = belief.p[area]


@kernel
def quantised(value: float, step: float, n_steps: float) -> float:
    """Round to the nearest multiple of a step that a word holds: at most n - 1 steps.

    >>> quantised(0.34, 0.25, 256.0)
    0.25
    >>> quantised(99.0, 0.25, 256.0)
    63.75
    """
    return min(math.floor(value / step + 0.5), n_steps - 1.0) * step


@kernel
def round_estimate(message: Message, area: int, n_steps: float) -> None:
    """Round the estimate of an area to words of n = `n_steps` values.

    The steps are DISTANCE_RANGE / n for distance, P_RANGE / n for p, 2 pi / n for direction.
    """
    message.distance[area] = quantised(message.distance[area], DISTANCE_RANGE / n_steps, n_steps)
    message.p[area] = quantised(message.p[area], P_RANGE / n_steps, n_steps)
    step = 2.0 * math.pi / n_steps
    message.direction[area] = wrap(math.floor(message.direction[area] / step + 0.5) * step)


@kernel
def compose(mind: SocialMind, numbers: Numbers) -> None:
    """Write the message: distance, direction and p of every area that the robot sends."""
    for area in range(2):
        mind.message.has_estimate[area] = sends_estimate(mind.belief, area, numbers)
        if mind.message.has_estimate[area]:
            write_estimate(mind.belief, area, mind.message)
            if numbers.n_steps > 0.0:
                round_estimate(mind.message, area, numbers.n_steps)
