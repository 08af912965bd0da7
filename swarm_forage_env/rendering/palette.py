"""Colours that colour-blind people can distinguish, each with one meaning.

Source: Okabe and Ito, Color Universal Design (2008), white and black too.
"""

from swarm_forage_env.scene import EXPLORING

Colour = tuple[int, int, int]

BLUE, ORANGE, GREEN = (0, 114, 178), (230, 159, 0), (0, 158, 115)
BLACK, WHITE, VERMILION = (0, 0, 0), (255, 255, 255), (213, 94, 0)

ROBOT: dict[int, Colour] = dict(enumerate((WHITE, BLUE, ORANGE, BLACK, GREEN)))
"""Colour of a robot by its state, in the order of `scene.STATES`. Exploring robots have no goal and
are white."""

AREA = (BLUE, ORANGE)
"""Colours of nest and prey, equal to those of robots on their way there."""

MESSAGE = GREEN
FAULTY = (204, 0, 0)
SELECTED = VERMILION

GOAL, RIGHT, WRONG = ORANGE, BLUE, FAULTY
"""Colours of goals, and of right and wrong claims."""

ESTIMATE, LIDAR = (204, 121, 167), (86, 180, 233)
"""Colours of estimated positions and of the reach of robots."""

PAGE, FLOOR = WHITE, (246, 246, 243)
INK, FAINT, RULE = (38, 38, 38), (108, 108, 108), (214, 214, 210)
WALL = (70, 70, 70)


def mixed(colour: Colour, ground: Colour, share: float) -> Colour:
    """Blend a share of a colour with a background.

    >>> mixed((200, 100, 0), (100, 100, 100), 0.5)
    (150, 100, 50)
    """
    r, g, b = (round(share * c + (1.0 - share) * d) for c, d in zip(colour, ground, strict=True))
    return r, g, b


def trail_colour(activity: int) -> Colour:
    """Return the colour of a trail: that of the robot, or grey where white would be invisible."""
    return (150, 150, 146) if activity == EXPLORING else ROBOT[activity]
