"""The differential drive against TR, Eq. 3, 4 and 7."""

import math

import pytest

from swarm_forage_env.equations.differential_drive import (
    advance,
    drive_to_wheels,
    path_length,
    wheels_to_arc,
)

AXLE = 0.053


@pytest.mark.parametrize(
    ("left", "right", "distance", "turn"),
    [
        (0.01, 0.01, 0.01, 0.0),
        (-0.01, -0.01, -0.01, 0.0),
        (-0.01, 0.01, 0.0, 0.02 / AXLE),
        (0.01, -0.01, 0.0, -0.02 / AXLE),
        (0.0, AXLE * math.pi / 2, AXLE * math.pi / 4, math.pi / 2),
    ],
)
def test_two_wheels_make_a_distance_and_a_turn(left, right, distance, turn):
    assert wheels_to_arc(left, right, AXLE) == pytest.approx((distance, turn))


@pytest.mark.parametrize(
    ("pose", "distance", "turn", "after"),
    [
        ((1.0, 2.0, math.pi / 6), 0.2, 0.0, (1.0 + 0.1 * math.sqrt(3.0), 2.1, math.pi / 6)),
        ((1.0, 2.0, 0.5), 0.0, -1.25, (1.0, 2.0, -0.75)),  # a spin in place
        # A quarter turn to the left over 0.1 m: the chord points half a quarter to the left.
        ((0.0, 0.0, 0.0), 0.1, math.pi / 2, (0.0707106781, 0.0707106781, math.pi / 2)),
        ((0.0, 0.0, 3.0), 0.0, 1.0, (0.0, 0.0, 4.0 - 2.0 * math.pi)),
    ],
)
def test_a_step_leads_along_its_chord_and_wraps_the_heading(pose, distance, turn, after):
    assert advance(*pose, distance, turn) == pytest.approx(after)


@pytest.mark.parametrize(
    ("distance", "turn", "path"),
    [
        (0.1, 0.0, 0.1),
        (-0.1, 0.0, 0.1),
        (0.0, 2.0, AXLE),
        (0.0, -2.0, AXLE),
        (0.1, 2.0, 0.1 + AXLE),
    ],
)
def test_a_turn_on_the_spot_is_a_path_too(distance, turn, path):
    assert path_length(distance, turn, AXLE) == pytest.approx(path)


@pytest.mark.parametrize(
    ("speed", "turn", "left", "right"),
    [
        (-1.0, 0.0, 0.0, 0.0),
        (-0.5, 1.0, 0.2, 0.8),
        (-1.0, -1.0, 0.3, -0.3),
        (1.0, 1.0, 0.7 / 1.3, 1.0),  # slowed down, so that the faster wheel is at its limit
        (1.0, -1.0, 1.0, 0.7 / 1.3),
    ],
)
def test_a_speed_and_a_turn_are_shared_among_the_wheels(speed, turn, left, right):
    assert drive_to_wheels(speed, turn, 0.3) == pytest.approx((left, right))
