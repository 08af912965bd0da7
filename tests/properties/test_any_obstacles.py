"""Whatever stands in the arena: nobody is inside a wall or beyond it, and nothing is NaN."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.epuck.obstacles import is_inside
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.arenas import regular_polygon
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.scenarios import find_scenario
from tests.properties.test_any_scenario import (
    A_FEW,
    OVERLAP,
    at_random,
    check,
    into_a_clump,
    straight,
    swarm,
    towards,
)

TICKS = 600
ANGLE = st.floats(0.0, 2.0 * math.pi)

NICHE = ((-1.1, -0.7), (1.1, -0.7), (1.1, 0.7), (0.2, 0.7), (0.1, 0.35), (-0.1, 0.7), (-1.1, 0.7))
"""An outer wall with a spike that points inwards."""

ARENAS = ((), NICHE, *(regular_polygon(n, 1.15) for n in (6, 8, 12)))


@st.composite
def obstacles(draw):
    """A disc, a wall, a chain or a polygon outside of the start circle."""
    far, angle, n = draw(st.floats(0.35, 0.6)), draw(ANGLE), draw(st.integers(1, 5))
    x, y = far * math.cos(angle), far * math.sin(angle)
    radius = draw(st.sampled_from([0.0, 0.005, 0.04]) if n > 1 else st.floats(0.005, 0.1))
    around = [(draw(ANGLE), draw(st.floats(0.03, 0.15))) for _ in range(n)]
    points = [(x + r * math.cos(a), y + r * math.sin(a)) for a, r in sorted(around)]
    return {"points": points, "radius": radius, "is_closed": n > 2 and draw(st.booleans())}


@st.composite
def scenarios(draw):
    """A crowd in an arena with up to five obstacles; those that it refuses are left out."""
    fastest = draw(st.floats(0.05, 0.175))
    numbers = {
        "arena.length": 2.4,
        "arena.width": 2.4,
        "arena.corners": draw(st.sampled_from(ARENAS)),
        "robot.max_speed": fastest,
        "robot.cruise_speed": fastest * draw(st.floats(0.3, 1.0)),
        "radio.is_shadowed": draw(st.booleans()),
        "task.n_robots": draw(st.integers(1, 20)),
        "task.area_distance": 1.6,
        "task.start_radius": 0.2,
        "task.duration": 1e4,
    }
    stand = []
    for each in draw(st.lists(obstacles(), min_size=1, max_size=5)):
        try:
            find_scenario("es1", {**numbers, "obstacles": [*stand, each]})
        except ConfigError:
            continue
        stand.append(each)
    return find_scenario("es1", {**numbers, "obstacles": stand})


def into_the_first(world, rng, tick, wheels):
    """Everybody at the first obstacle, or at a corner of the outer wall."""
    scenario = world.scenario
    corners = [each.points[0] for each in scenario.obstacles] + [*scenario.arena.corners]
    return towards(world, *(corners or [(1.2, 0.0)])[0])


def into_a_corner_of_the_outer_wall(world, rng, tick, wheels):
    return towards(world, *([*world.scenario.arena.corners] or [(1.2, 1.2)])[-3:][0])


DRIVERS = (
    at_random,
    straight,
    into_a_clump,
    into_the_first,
    into_a_corner_of_the_outer_wall,
    "ssgikf",
    "dsgiff",
)


def check_obstacles(world):
    scenario = world.scenario
    a, b = world.obstacles[0, :, :2], world.obstacles[0, :, 2:4]
    axis = b - a
    for place in world.state.pose[:, :2]:
        along = ((place - a) * axis).sum(axis=1) / np.maximum((axis**2).sum(axis=1), 1e-300)
        nearest = a + np.clip(along, 0.0, 1.0)[:, None] * axis
        gap = np.hypot(*(place - nearest).T) - world.obstacles[0, :, 4] - scenario.robot.radius
        assert gap.min(initial=math.inf) > -OVERLAP
        if scenario.arena.corners:
            assert is_inside(tuple(place), scenario.arena.corners)
        for obstacle in scenario.obstacles:
            assert not (obstacle.is_closed and is_inside(tuple(place), obstacle.points))


@pytest.mark.parametrize("physics", list(ENGINES))
@A_FEW
@given(scenario=scenarios(), driver=st.sampled_from(DRIVERS), seed=st.integers(0, 2**64 - 1))
def test_nobody_is_inside_or_beyond_a_wall(physics, scenario, driver, seed):
    world, step = swarm(scenario, driver, physics, seed)
    for tick in range(TICKS):
        step(tick)
        if tick % 5 == 0:
            check(world)
            check_obstacles(world)
