"""Infrared: the published response, and rays to robots and walls."""

import math

import numpy as np
import pytest

from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.proximity import (
    PROXIMITY_ANGLES,
    RAY_COS,
    RAY_SIN,
    SENSING_RANGE,
    ray_to_disc,
    ray_to_walls,
    response,
)

RADIUS = 0.035
ARENA = np.array([1.7, 1.2])
LEFT = 5
"""The sensor at +90 degrees."""


def test_the_sensors_look_in_the_published_directions():
    # ARGoS numbers clockwise from the front right: 17, 50, 90, 150, 210, 270, 310, 343 degrees.
    clockwise = np.degrees(-PROXIMITY_ANGLES) % 360.0
    np.testing.assert_allclose(clockwise, [17, 50, 90, 150, 210, 270, 310, 343])
    rays = [(float(c), float(s)) for c, s in zip(RAY_COS, RAY_SIN, strict=True)]
    assert rays == [cos_sin(angle) for angle in PROXIMITY_ANGLES]


@pytest.mark.parametrize(
    ("d", "reading"),
    [
        (0.0, 1.0),  # the curve starts at 1.08212 and is cut at 1
        (0.01, 0.7430291),
        (0.02, 0.4636784),
        (0.04, 0.0841976),
        (0.05, 0.0),
        (0.0500001, 0.0),
        (0.1, 0.0),
        (math.inf, 0.0),
    ],
)
def test_the_response_is_the_published_curve(d, reading):
    assert response(d) == pytest.approx(reading, abs=1e-9)


@pytest.mark.parametrize("ray", range(8))
@pytest.mark.parametrize("gap", [0.0, 0.013, 0.05])
def test_a_disc_straight_in_front_of_a_sensor_is_at_its_gap(ray, gap):
    d = 2.0 * RADIUS + gap
    angle = PROXIMITY_ANGLES[ray]
    assert ray_to_disc(d * math.cos(angle), d * math.sin(angle), ray, RADIUS) == pytest.approx(gap)


def test_a_disc_straight_ahead_is_seen_aslant_by_both_front_sensors():
    # Centre at 0.1 m: the ray at 17 degrees leaves 0.1 cos 17 = 0.09563 m along and passes
    # 0.1 sin 17 = 0.02924 m aside; half the chord is sqrt(0.035^2 - 0.02924^2) = 0.01924 m.
    expected = 0.09563048 - 0.01924017 - 0.035
    for ray in (0, 7):
        assert ray_to_disc(0.1, 0.0, ray, RADIUS) == pytest.approx(expected, abs=1e-6)
    for ray in (1, 2, 3, 4, 5, 6):
        assert ray_to_disc(0.1, 0.0, ray, RADIUS) == math.inf


@pytest.mark.parametrize("ray", range(8))
def test_a_disc_that_a_ray_only_grazes_is_not_seen(ray):
    angle = PROXIMITY_ANGLES[ray]
    for lateral in (-1.0, 1.0):
        for way, is_seen in ((1.0 + 1e-9, False), (1.0 - 1e-9, True)):
            across = lateral * way * RADIUS
            ahead = 0.08 * math.cos(angle) - across * math.sin(angle)
            left = 0.08 * math.sin(angle) + across * math.cos(angle)
            assert (ray_to_disc(ahead, left, ray, RADIUS) < math.inf) == is_seen


@pytest.mark.parametrize(
    ("ahead", "left", "distance"),
    [
        (0.0, -0.08, math.inf),  # behind
        (RADIUS + 1e-6, 0.08, math.inf),  # aside
        (0.01, -1e-9, math.inf),  # abreast: not seen though it overlaps
        (0.01, 1e-9, 0.0),
        (0.0, 0.06, 0.0),
    ],
)
def test_a_disc_is_seen_in_front_of_a_sensor_only_and_no_nearer_than_zero(ahead, left, distance):
    assert ray_to_disc(ahead, left, LEFT, RADIUS) == distance


def ray_at(x, y, direction):
    """Distance to the walls along a direction of the world frame."""
    return ray_to_walls(x, y, math.cos(direction), math.sin(direction), ARENA, RADIUS)


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.049])
@pytest.mark.parametrize(
    ("side", "direction"),
    [((1, 0), 0.0), ((0, 1), math.pi / 2), ((-1, 0), math.pi), ((0, -1), -math.pi / 2)],
)
def test_a_wall_on_any_side_is_at_its_gap_and_no_other_is_near(gap, side, direction):
    x, y = np.array(side) * (0.5 * ARENA - RADIUS - gap)
    assert ray_at(x, y, direction) == pytest.approx(gap, abs=1e-12)
    for turn in (math.pi / 2, math.pi, -math.pi / 2):
        assert ray_at(x, y, direction + turn) == math.inf


@pytest.mark.parametrize("direction", [0.3, 1.2, 2.0, 2.9, -0.3, -1.2, -2.0, -2.9])
@pytest.mark.parametrize("beyond", [-0.04, -0.001, 0.04])
def test_a_wall_is_as_far_as_it_is_drawn_on_paper(direction, beyond):
    """Aslant from near a corner; the body may be pressed into the wall."""
    c, s = math.cos(direction), math.sin(direction)
    x, y = (math.copysign(0.5 * side - RADIUS - beyond, way)
            for side, way in zip(ARENA, (c, s), strict=True))  # fmt: skip
    expected = min((RADIUS + beyond) / abs(c), (RADIUS + beyond) / abs(s)) - RADIUS
    found = ray_at(x, y, direction)
    assert found == (pytest.approx(max(expected, 0.0)) if expected <= SENSING_RANGE else math.inf)
