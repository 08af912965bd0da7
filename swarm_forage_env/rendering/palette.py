"""Colours that the colour-blind tell apart, each with one meaning.

Source: Okabe and Ito, Color Universal Design (2008); white and black are from there, too.
"""

from swarm_forage_env.scene import EXPLORING

Colour = tuple[int, int, int]

BLUE, ORANGE, GREEN = (0, 114, 178), (230, 159, 0), (0, 158, 115)
BLACK, WHITE, VERMILION = (0, 0, 0), (255, 255, 255), (213, 94, 0)

DOING: dict[int, Colour] = dict(enumerate((WHITE, BLUE, ORANGE, BLACK, GREEN)))
"""Body of a robot by what it is doing, as `scene.STATES`. Exploring is white: it has no goal to be
coloured by."""

AREA = (BLUE, ORANGE)
"""Nest and prey, in the colour of the robots that are on their way there."""

MESSAGE = GREEN
FAULTY = (204, 0, 0)
SELECTED = VERMILION

GOAL, RIGHT, WRONG = ORANGE, BLUE, FAULTY
"""Where a robot is to go, and claims to be there."""

ESTIMATE, LIDAR = (204, 121, 167), (86, 180, 233)
"""Where a robot believes it is, and how far it sees."""

PAGE, FLOOR = WHITE, (246, 246, 243)
INK, FAINT, RULE = (38, 38, 38), (108, 108, 108), (214, 214, 210)
WALL = (70, 70, 70)


def mixed(colour: Colour, ground: Colour, share: float) -> Colour:
    """That share of a colour on a ground.

    >>> mixed((200, 100, 0), (100, 100, 100), 0.5)
    (150, 100, 50)
    """
    r, g, b = (round(share * c + (1.0 - share) * d) for c, d in zip(colour, ground, strict=True))
    return r, g, b


def trail_colour(doing: int) -> Colour:
    """What a trail is drawn in: as the body, but for white, which the floor would swallow."""
    return (150, 150, 146) if doing == EXPLORING else DOING[doing]
