"""The grid of cells in which neighbours are looked for."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.equations.neighbours import cell_of, cells_of

SIDES, REACHES = st.floats(0.05, 10.0), st.floats(0.05, 3.0)


@pytest.mark.parametrize(
    ("side", "reach", "cells"), [(1.7, 0.16, 10), (1.7, 0.171, 9), (1.2, 0.5, 2), (0.1, 0.15, 1)]
)
def test_a_cell_is_at_least_as_wide_as_the_reach(side, reach, cells):
    assert cells_of(side, reach) == cells


@pytest.mark.parametrize(
    ("coordinate", "cell"), [(-0.5, 0), (-0.31, 0), (-0.29, 1), (0.0, 2), (0.49, 4), (0.5, 4)]
)
def test_cells_are_counted_from_the_wall_where_the_coordinate_is_least(coordinate, cell):
    assert cell_of(coordinate, 1.0, 0.2, 5) == cell


def test_what_lies_outside_the_walls_counts_to_the_outermost_cell():
    assert (cell_of(-7.0, 1.0, 0.2, 5), cell_of(7.0, 1.0, 0.2, 5)) == (0, 4)


@given(SIDES, REACHES, st.floats(-6.0, 6.0), st.floats(-1.0, 1.0))
def test_what_is_within_reach_is_in_the_same_cell_or_the_next(side, reach, x, share):
    cells = cells_of(side, reach)
    here = cell_of(x, side, reach, cells)
    there = cell_of(x + 0.999 * share * reach, side, reach, cells)
    assert 0 <= here < cells
    assert abs(here - there) <= 1
