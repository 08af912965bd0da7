"""Steering: a direction or a command becomes a change of velocity."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.equations.steering import drive_to_pull, seek

SPEEDS = st.floats(-0.5, 0.5)


@pytest.mark.parametrize(
    ("strength", "turn", "ahead", "left"),
    [
        (1.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 0.5, 0.0),
        (-1.0, 0.7, 0.0, 0.0),  # no strength, no pull
        (1.0, 1.0, math.cos(0.3 * math.pi), math.sin(0.3 * math.pi)),
        (0.0, -0.5, 0.5 * math.cos(0.15 * math.pi), -0.5 * math.sin(0.15 * math.pi)),
    ],
)
def test_a_command_is_a_pull_of_a_size_and_a_direction(strength, turn, ahead, left):
    assert drive_to_pull(strength, turn, 0.3) == pytest.approx((ahead, left))


@pytest.mark.parametrize(
    ("direction", "velocity", "change"),
    [
        ((3.0, 4.0), (0.0, 0.0), (0.6, 0.8)),
        ((0.3, 0.4), (0.0, 0.0), (0.6, 0.8)),  # a direction has no size
        ((3.0, 4.0), (-0.3, 0.1), (0.6 / math.hypot(0.6, 0.3), 0.3 / math.hypot(0.6, 0.3))),
        ((3.0, 4.0), (0.3, 0.4), (0.0, 0.0)),  # it goes there already, at its highest speed
        ((0.0, 0.0), (0.3, 0.4), (0.0, 0.0)),
        ((0.0, 2.0), (0.0, 0.0), (0.0, 1.0)),
    ],
)
def test_a_robot_is_turned_towards_the_velocity_it_should_have(direction, velocity, change):
    assert seek(*direction, *velocity, 0.5) == pytest.approx(change, abs=1e-12)


@given(st.floats(-math.pi, math.pi), st.floats(0.01, 10.0), SPEEDS, SPEEDS)
def test_the_change_of_velocity_points_from_the_present_one_to_the_wanted_one(angle, size, vx, vy):
    x, y = math.cos(angle), math.sin(angle)
    change = seek(size * x, size * y, vx, vy, 0.5)
    wanted = 0.5 * x - vx, 0.5 * y - vy
    if math.hypot(*wanted) > 1e-6:
        assert math.hypot(*change) == pytest.approx(1.0)
        assert change[0] * wanted[1] == pytest.approx(change[1] * wanted[0], abs=1e-9)
        assert change[0] * wanted[0] + change[1] * wanted[1] > 0.0
