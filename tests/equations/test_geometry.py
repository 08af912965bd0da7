"""Angles and frames."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.equations.geometry import range_and_bearing, to_body, to_outer, wrap

ANGLES = st.floats(-1e4, 1e4)
LENGTHS = st.floats(-10.0, 10.0)


def turned(theta):
    """Cosine and sine of a heading, as the frames take it."""
    return math.cos(theta), math.sin(theta)


@given(ANGLES)
def test_a_wrapped_angle_is_the_same_direction_in_range(angle):
    wrapped = wrap(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-11)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-11)


@given(st.integers(-1000, 1000), st.integers(-4, 4))
def test_angles_within_rounding_of_the_border_stay_in_range(turns, steps):
    border = math.pi + 2.0 * math.pi * turns
    for _ in range(abs(steps)):
        border = math.nextafter(border, math.copysign(math.inf, steps))
    assert -math.pi <= wrap(border) < math.pi


@pytest.mark.parametrize(
    ("theta", "ahead", "left"),
    [(0.0, 3.0, 4.0), (math.pi / 2, 4.0, -3.0), (-math.pi / 2, -4.0, 3.0), (math.pi, -3.0, -4.0)],
)
def test_a_point_is_ahead_and_to_the_left_as_drawn_on_paper(theta, ahead, left):
    assert to_body(3.0, 4.0, *turned(theta)) == pytest.approx((ahead, left))


@given(LENGTHS, LENGTHS, ANGLES)
def test_into_the_body_frame_and_back_is_where_one_was(dx, dy, theta):
    ahead, left = to_body(dx, dy, *turned(theta))
    assert to_outer(ahead, left, *turned(theta)) == pytest.approx((dx, dy), abs=1e-12)
    assert math.hypot(ahead, left) == pytest.approx(math.hypot(dx, dy), abs=1e-12)


@given(st.floats(0.01, 10.0), st.floats(-3.1, 3.1), ANGLES)
def test_range_and_bearing_are_the_polar_form_of_the_body_frame(r, bearing, theta):
    dx, dy = to_outer(r * math.cos(bearing), r * math.sin(bearing), *turned(theta))
    assert range_and_bearing(dx, dy, theta) == pytest.approx((r, bearing), abs=1e-9)
