"""Infrared, on robots put at given places."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.equations.proximity import (
    PROXIMITY_ANGLES,
    ray_to_disc,
    ray_to_walls,
    response,
)

RADIUS = 0.035
ARENA = np.array([1.7, 1.2])


@given(
    st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-3.0, 3.0)),
             min_size=1, max_size=5),
    st.sampled_from([(0.0, 0.0), (0.75, 0.0), (0.0, -0.5), (-0.75, 0.5)]),
)  # fmt: skip
def test_a_sensor_reads_the_nearest_of_all_robots_and_walls(block, places, corner):
    pose = np.array(places) + np.array([*corner, 0.0])
    pose[:, :2] = np.clip(pose[:, :2], RADIUS - 0.5 * ARENA, 0.5 * ARENA - RADIUS)
    seen = block(pose, proximity_noise=0.0).sense().proximity
    for i, (x, y, theta) in enumerate(pose):
        c, s = math.cos(theta), math.sin(theta)
        for ray, angle in enumerate(PROXIMITY_ANGLES):
            u, v = math.cos(theta + angle), math.sin(theta + angle)
            away = [ray_to_walls(x, y, u, v, ARENA, RADIUS)]
            for dx, dy in np.delete(pose[:, :2], i, axis=0) - (x, y):
                away.append(ray_to_disc(c * dx + s * dy, c * dy - s * dx, ray, RADIUS))
            assert seen[i, ray] == pytest.approx(response(min(away)), abs=1e-6)
