"""Steering: a direction or a command becomes a change of velocity."""

import math

import pytest

from swarm_forage_env.equations.steering import drive_to_pull, seek


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
