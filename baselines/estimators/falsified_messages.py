"""Falsified messages: faults of the scenario change a message after a robot composed it.

A liar sends a false location; a stale robot repeats its first message. Their beliefs are unchanged.

Not in the papers, and chosen here:
- a liar falsifies the areas that it would report, and sends messages when it would send them;
- a stale robot keeps the first message in which it reports an area, and repeats that place in its
  own frame, with the p of that time;
- the error ellipse sent with a lie is a circle whose radius is the reported p.
"""

from baselines.estimators.belief import SocialMind
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import Lie
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot
from swarm_forage_env.equations.geometry import range_and_bearing, wrap


@kernel
def false_place(distance: float, direction: float, lie: Lie, area: int) -> tuple[float, float]:
    """Return the distance [m] and direction [rad] that a liar sends for a believed area.

    In the body frame: turned about the liar and shifted, or a fixed one. Source: VanCalck2023, for
    locations that are turned.
    """
    x, y = lie.place[area, 0], lie.place[area, 1]
    if not lie.is_place:
        c, s = cos_sin(direction + lie.turn)
        x += distance * c
        y += distance * s
    return hypot(x, y), atan2(y, x)


@kernel
def falsify(mind: SocialMind, lie: Lie) -> None:
    """Replace the locations in a message by those of a lie, and p unless the lie keeps it."""
    message = mind.message
    for area in range(2):
        if message.has_estimate[area]:
            distance, direction = float(message.distance[area]), float(message.direction[area])
            distance, direction = false_place(distance, direction, lie, area)
            message.distance[area], message.direction[area] = distance, wrap(direction)
            if not lie.has_own_p:
                message.p[area] = lie.p


@kernel
def retell(mind: SocialMind) -> None:
    """Write the stale message again, with its locations as seen from the present believed pose."""
    message, then, now = mind.message, mind.stale_pose, mind.belief.pose
    mind.message = mind.stale_message
    for area in range(2):
        if message.has_estimate[area]:
            distance, direction = float(message.distance[area]), message.direction[area] + then[2]
            c, s = cos_sin(direction)
            dx = then[0] + distance * c - now[0]
            dy = then[1] + distance * s - now[1]
            distance, direction = range_and_bearing(dx, dy, now[2])
            message.distance[area], message.direction[area] = distance, direction


@kernel
def repeat(mind: SocialMind) -> bool:
    """Replace the message by the stale one, or keep this one; return whether it was replaced."""
    if mind.has_stale_message:
        retell(mind)
        return True
    if mind.message.has_estimate[0] or mind.message.has_estimate[1]:
        mind.stale_message, mind.stale_pose = mind.message, mind.belief.pose
        mind.has_stale_message = True
    return False
