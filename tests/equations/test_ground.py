"""The floor: which area holds a point, and how bright it is there."""

import numpy as np
import pytest

from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.equations.ground import FLOOR, area_at, brightness

AREAS = np.array([[-0.4, 0.0], [0.4, 0.0]])


@pytest.mark.parametrize(
    ("x", "y", "area"),
    [
        (-0.4, 0.0, NEST),
        (0.4, 0.0, PREY),
        (-0.4, 0.0999, NEST),
        (-0.4, 0.1001, FLOOR),
        (0.32, 0.05, PREY),
        (0.0, 0.0, FLOOR),
        (0.4, 0.5, FLOOR),
    ],
)
def test_a_point_lies_in_nest_prey_or_neither(x, y, area):
    assert area_at(x, y, AREAS, len(AREAS), 0.1) == area


def test_the_nest_is_black_the_prey_grey_and_the_floor_white():
    assert (brightness(NEST), brightness(PREY), brightness(FLOOR)) == (0.0, 0.5, 1.0)
