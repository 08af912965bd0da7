"""A scene as text: a map of characters, for terminals and logs; no drawing library is needed."""

import numpy as np

from swarm_forage_env.arrays import NEST, Array, Float64
from swarm_forage_env.scene import Scene, Stage

COLUMNS = 60
"""Characters across an arena."""

ASPECT = 2.0
"""How much higher than broad a character is."""

FLOOR, NEST_SIGN, PREY_SIGN, ROBOT, GOAL = ".#%o+"


def text_of(stage: Stage, scene: Scene) -> str:
    """The arena from above, x to the right and y upwards, and a line of the time and the score.

    A robot is its last digit where there are up to ten, else `o`; areas are # and %, goals +.
    """
    rows = max(1, round(COLUMNS * stage.width / stage.length / ASPECT))
    size, half = np.array([COLUMNS, rows]), np.array([stage.length, stage.width]) / 2.0
    x, y = np.meshgrid(*((np.arange(n) + 0.5) / n * 2.0 - 1.0 for n in size))
    places = np.stack([x * half[0], y * half[1]], axis=-1)
    signs = np.full((rows, COLUMNS), FLOOR)
    for kind, centre in zip(stage.kinds, stage.areas_at(scene.time), strict=True):
        is_inside = np.hypot(*np.moveaxis(places - centre, -1, 0)) <= stage.area_radius
        signs[is_inside] = NEST_SIGN if kind == NEST else PREY_SIGN
    if scene.localised is not None:
        signs[_cells(scene.localised.goal, half, size)] = GOAL
    column, row = _cells(scene.pose[:, :2], half, size)[::-1]
    digits = [str(k) if stage.n_robots <= 10 else ROBOT for k in range(stage.n_robots)]
    signs[row, column] = digits
    score, share = stage.headings
    told = f"{scene.time:.1f} s, {score.lower()} {scene.total}, {share.lower()} {scene.share:.0%}"
    return "\n".join(["".join(line) for line in signs[::-1]] + [told])


def _cells(places: Float64[Array, "places 2"], half: Array, size: Array) -> tuple[Array, Array]:
    """Row and column of each place; those beyond the arena at its rim."""
    cells = np.clip(((places / half + 1.0) / 2.0 * size).astype(np.int64), 0, size - 1)
    return cells[:, 1], cells[:, 0]
