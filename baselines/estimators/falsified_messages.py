"""Falsified messages: what faults of the scenario make of a message that a robot composed.

A liar tells a false place; a stale robot repeats what it told once. The robot itself believes what
it believed before.

Not in the papers, and chosen here:
- a liar lies about the areas that it would tell of, and speaks when it would speak;
- a stale robot keeps the first message in which it tells of an area, and goes on telling that place
  in its own frame, with the p of then;
- the error ellipse that goes with a lie is a circle of the p told.
"""

from baselines.estimators.belief import Message, SocialMind
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import Lie
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot
from swarm_forage_env.equations.geometry import range_and_bearing, wrap


@kernel
def false_place(distance: float, direction: float, lie: Lie, area: int) -> tuple[float, float]:
    """Where a liar says that an area is, which it believes at a distance [m] and direction [rad].

    Body frame, distance [m] and direction [rad]. Turned about the liar and shifted, or a place of
    its own. Source: VanCalck2023, for places that are turned.
    """
    x, y = lie.place[area, 0], lie.place[area, 1]
    if not lie.is_place:
        c, s = cos_sin(direction + lie.turn)
        x += distance * c
        y += distance * s
    return hypot(x, y), atan2(y, x)


@kernel
def tell_lies(message: Message, lie: Lie) -> None:
    """Put false places, and the p of the lie, into a message."""
    for area in range(2):
        if message.told[area]:
            honest = float(message.distance[area]), float(message.direction[area])
            distance, direction = false_place(honest[0], honest[1], lie, area)
            message.distance[area], message.direction[area] = distance, wrap(direction)
            if not lie.has_own_p:
                message.p[area] = lie.p


@kernel
def falsify(mind: SocialMind, lie: Lie) -> None:
    """Make a lie of the message of a robot."""
    tell_lies(mind.message, lie)


@kernel
def copy_message(source: Message, out: Message) -> None:
    """Copy what a message tells of both areas."""
    for area in range(2):
        out.told[area] = source.told[area]
        out.distance[area], out.direction[area] = source.distance[area], source.direction[area]
        out.p[area] = source.p[area]


@kernel
def keep_first(mind: SocialMind) -> bool:
    """Keep the message if it is the first that tells of an area; whether one was kept before."""
    if mind.kept.is_kept:
        return True
    if mind.message.told[0] or mind.message.told[1]:
        copy_message(mind.message, mind.kept)
        for k in range(3):
            mind.kept.pose[k] = mind.belief.pose[k]
        mind.kept.is_kept = True
    return False


@kernel
def retell(mind: SocialMind) -> None:
    """Tell again the places that were kept, as they are seen from the believed pose of now."""
    message, then, now = mind.message, mind.kept.pose, mind.belief.pose
    copy_message(mind.kept, message)
    for area in range(2):
        if message.told[area]:
            distance, direction = float(message.distance[area]), message.direction[area] + then[2]
            c, s = cos_sin(direction)
            dx = then[0] + distance * c - now[0]
            dy = then[1] + distance * s - now[1]
            distance, direction = range_and_bearing(dx, dy, now[2])
            message.distance[area], message.direction[area] = distance, wrap(direction)


@kernel
def repeat(mind: SocialMind) -> None:
    """Put what was told first in the place of the message of a robot."""
    if keep_first(mind):
        retell(mind)
