"""Capsules: where a disc touches one, and where a ray meets one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations import obstacles

from_axis = entry_point(obstacles.from_axis)
is_between = entry_point(obstacles.is_between)
keep_out = entry_point(obstacles.keep_out)
ray_to_capsule = entry_point(obstacles.ray_to_capsule)
WALL = np.array([0.0, -1.0, 0.0, 1.0, 0.1])
"""An upright wall, 20 cm thick."""
THIN = np.array([0.0, -1.0, 0.0, 1.0, 0.0])
DISC = np.array([0.0, 0.0, 0.0, 0.0, 0.5])

PLACE = st.floats(-2.0, 2.0)
CAPSULES = st.tuples(PLACE, PLACE, PLACE, PLACE, st.floats(0.0, 0.5)).map(np.array)


def gap(x, y, capsule):
    """From a place to a capsule [m], by comparing with many points of its axis."""
    share = np.linspace(0.0, 1.0, 20001)
    px = capsule[0] + share * (capsule[2] - capsule[0])
    py = capsule[1] + share * (capsule[3] - capsule[1])
    return np.hypot(px - x, py - y).min() - capsule[4]


@given(CAPSULES, PLACE, PLACE)
def test_no_point_of_an_axis_is_nearer(capsule, x, y):
    assert math.hypot(*from_axis(x, y, capsule)) - capsule[4] == pytest.approx(
        gap(x, y, capsule), abs=1e-3
    )


@given(CAPSULES, PLACE, PLACE, st.floats(0.01, 0.5))
def test_a_disc_that_was_moved_out_touches_and_one_beside_stays(capsule, x, y, radius):
    pose = np.array([x, y, 1.0])
    before = math.hypot(*from_axis(x, y, capsule)) - capsule[4] - radius
    short = keep_out(pose, capsule, radius)
    if before >= 0.0:
        assert (short, *pose) == (0.0, x, y, 1.0)
    else:
        assert short == pytest.approx(-before)
        after = math.hypot(*from_axis(pose[0], pose[1], capsule)) - capsule[4] - radius
        assert after == pytest.approx(0.0, abs=1e-9)


SLANTED = np.array([0.0, 0.0, 0.6, 0.8, 0.1])


@pytest.mark.parametrize(
    ("capsule", "place", "way"),
    [
        (WALL, (0.0, 0.3), (-0.3, 0.0)),
        (DISC, (0.0, 0.0), (0.7, 0.0)),
        (SLANTED, (0.3, 0.4), (-0.24, 0.18)),
        (SLANTED, (0.3 + 0.8e-10, 0.4 - 0.6e-10), (-0.24, 0.18)),  # nearer than a nanometre
        (SLANTED, (0.3 + 0.8e-8, 0.4 - 0.6e-8), (0.24, -0.18)),
    ],
)
def test_a_disc_on_an_axis_leaves_it_to_the_left_and_a_point_along_x(capsule, place, way):
    pose = np.array([*place, 1.0])
    keep_out(pose, capsule, 0.2)
    assert pose == pytest.approx([place[0] + way[0], place[1] + way[1], 1.0], abs=1e-7)


@pytest.mark.parametrize("start", [0.0, 0.25, 2.0])
@pytest.mark.parametrize("across", [-0.5, 0.5])
def test_a_ray_that_only_grazes_a_disc_misses_it(start, across):
    assert ray_to_capsule(-start, across, 1.0, 0.0, DISC) == math.inf


@pytest.mark.parametrize("y", [-1.0, -0.999, 0.0, 0.999, 1.0])
@pytest.mark.parametrize("x", [0.0, 1.0, -1.0])
def test_a_thin_wall_is_met_from_end_to_end(x, y):
    u = -1.0 if x > 0.0 else 1.0
    assert ray_to_capsule(x, y, u, 0.0, THIN) == abs(x)
    assert ray_to_capsule(x, 1.001 * y, u, 0.0, THIN) == (math.inf if abs(y) > 0.999 else abs(x))


@pytest.mark.parametrize(
    ("capsule", "start", "direction", "far"),
    [
        (THIN, (1.0, 0.0), (-math.sqrt(0.5), math.sqrt(0.5)), math.sqrt(2.0)),
        (THIN, (1.0, 0.0), (-0.6, 0.8), math.inf),  # past its end
        (THIN, (0.0, 2.0), (0.0, -1.0), math.inf),  # along it
    ],
)
def test_a_ray_meets_a_capsule_where_it_should(capsule, start, direction, far):
    assert ray_to_capsule(*start, *direction, capsule) == pytest.approx(far)


@given(CAPSULES, PLACE, PLACE, st.floats(0.0, 2.0 * math.pi))
def test_where_a_ray_meets_a_capsule_is_its_rim_and_nothing_lies_before(capsule, x, y, angle):
    if gap(x, y, capsule) < 1e-3:
        return
    u, v = math.cos(angle), math.sin(angle)
    far = ray_to_capsule(x, y, u, v, capsule)
    for way in np.linspace(0.0, min(far, 6.0) - 1e-6, 50):
        dx, dy = from_axis(x + way * u, y + way * v, capsule)
        assert math.hypot(dx, dy) >= capsule[4] - 1e-6
    if math.isfinite(far):
        dx, dy = from_axis(x + far * u, y + far * v, capsule)
        assert math.hypot(dx, dy) == pytest.approx(capsule[4], abs=1e-6)


@pytest.mark.parametrize(
    ("here", "there", "expected"),
    [
        ((-1.0, 0.0), (1.0, 0.0), True),
        ((-1.0, 0.0), (-0.11, 0.0), False),
        ((-1.0, 0.0), (0.3, 0.0), True),
        ((-1.0, 0.0), (1.0, 3.0), False),
        ((-1.0, 0.0), (-1.0, 0.0), False),
        ((-0.4, -0.9), (0.4, 0.9), True),
        ((-0.4, 1.0), (0.4, 1.6), False),  # over its end
        ((-0.4, 0.8), (0.4, 1.4), True),
    ],
)
def test_a_wall_lies_between_those_on_its_two_sides(here, there, expected):
    assert is_between(*here, *there, WALL) == expected
    assert is_between(*there, *here, WALL) == expected


def test_who_touches_a_wall_is_not_behind_it():
    assert not is_between(-1.0, 0.0, -0.1, 0.0, WALL)
