"""The floor: which area holds a point, and how bright it is there."""

import numpy as np
import pytest

from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.equations.ground import FLOOR, area_at, brightness

SEVERAL = np.array([[-0.5, 0.0], [0.5, 0.0], [0.0, 0.5], [0.0, -0.5], [2.0, 2.0]])
"""Nest, prey area, two more, and one that is not there."""


@pytest.mark.parametrize(("n_areas", "found"), [(2, 2), (3, 3), (4, 4), (5, 5)])
def test_of_several_areas_those_that_are_there_are_found(n_areas, found):
    at = [area_at(x, y, SEVERAL, n_areas, 0.1) for x, y in SEVERAL]
    assert at == [*range(found), *[FLOOR] * (5 - found)]


@pytest.mark.parametrize("area", range(4))
@pytest.mark.parametrize("way", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_the_rim_of_an_area_belongs_to_it(area, way):
    x, y = SEVERAL[area] + 0.25 * np.array(way)  # exact in binary, as is its distance
    assert area_at(x, y, SEVERAL, 5, 0.25) == area
    x, y = SEVERAL[area] + 0.2500001 * np.array(way)
    assert area_at(x, y, SEVERAL, 5, 0.25) == FLOOR
    x, y = SEVERAL[area] + [0.2, 0.2]  # areas are round
    assert area_at(x, y, SEVERAL, 5, 0.25) == FLOOR


def test_where_areas_overlap_the_first_one_is_found():
    together = np.zeros((4, 2))
    assert area_at(0.0, 0.0, together, 4, 0.1) == NEST
    together[0] = 1.0
    assert area_at(0.0, 0.0, together, 4, 0.1) == PREY
    together[1] = 1.0
    assert area_at(0.0, 0.0, together, 4, 0.1) == 2


@pytest.mark.parametrize(
    ("area", "level"), [(NEST, 0.0), (PREY, 0.5), (FLOOR, 1.0), (2, 1.0), (7, 1.0)]
)
def test_the_nest_is_black_the_prey_grey_and_all_else_white(area, level):
    assert brightness(area) == level
