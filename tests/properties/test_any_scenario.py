"""Whatever the scenario: nothing is NaN, nobody is beyond or inside a wall, no bodies overlap."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

import baselines.controllers  # noqa: F401 enters the controllers
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.obstacles import is_inside
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.arenas import regular_polygon
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.loop import Loop
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.columns import columns

TICKS = 1000
OVERLAP = 1e-3
"""Bodies may overlap by less than this [m]."""

FASTEST = 0.5
"""Way of the fastest wheels in a tick, in radii of the robot."""

MAX_ROBOTS = 40
SHARE, GROWTH = st.floats(0.0, 1.0), st.floats(1.0001, 1.5)


@st.composite
def scenarios(draw):
    """A valid scenario: from a lonely robot to a crowd, from a crawl to the speed limit."""
    radius = draw(st.floats(0.01, 0.1))
    start = radius * draw(st.floats(0.1, 12.0))
    area = draw(st.floats(0.3, 3.0)) * radius
    distance = 2.0 * (start + area) * draw(GROWTH)
    tick = draw(st.sampled_from([0.05, 0.1, 0.2]))
    fastest = FASTEST * radius / tick * draw(st.floats(0.05, 1.0))
    reach = draw(st.floats(0.02, 0.4))
    near_share, losses = draw(st.floats(0.0, 0.9)), sorted((draw(SHARE), draw(SHARE)))
    max_robots = max(1, min(MAX_ROBOTS, int(0.5 * (start / radius) ** 2)))
    return Scenario(
        tick=tick,
        arena={
            "length": max(distance + 2.0 * area, 2.0 * (start + radius)) * draw(GROWTH),
            "width": 2.0 * max(start + radius, area) * draw(GROWTH),
        },
        robot={
            "radius": radius,
            "axle": radius * draw(st.floats(0.5, 2.0)),
            "max_speed": fastest,
            "cruise_speed": fastest * draw(st.floats(0.2, 1.0)),
        },
        sensors={
            "proximity_noise": draw(SHARE),
            "ground_noise": draw(SHARE),
            "wheel_noise": draw(SHARE),
            "ground_ahead": radius * draw(SHARE),
        },
        radio={
            "max_range": reach,
            "near": near_share * reach,
            "loss_near": losses[0],
            "loss_far": losses[1],
            "range_noise": draw(st.floats(0.0, 0.1)),
            "bearing_noise": draw(st.floats(0.0, 3.0)),
            "range_model": draw(st.sampled_from(["uniform", "board"])),
            "frames": draw(st.integers(1, 20)),
            "slots": draw(st.integers(1, 6)),
            "exchange_time": draw(st.floats(0.05, 2.0)),
        },
        task={
            "n_robots": draw(st.integers(1, max_robots)),
            "duration": 1e4,
            "area_radius": area,
            "area_distance": distance,
            "start_radius": start,
        },
    )


def towards(world, x, y):
    """Wheels at full speed for everyone to one place [m]."""
    pose = world.state.pose
    off = np.angle(np.exp(1j * (np.arctan2(y - pose[:, 1], x - pose[:, 0]) - pose[:, 2])))
    return np.clip(np.stack([1.0 - off, 1.0 + off], axis=1), -1.0, 1.0)


def at_random(world, rng, tick, wheels):
    """New wheels for everyone each 20 ticks."""
    return rng.uniform(-1.0, 1.0, (world.rows, 2)) if tick % 20 == 0 else wheels


def straight(world, rng, tick, wheels):
    """At full speed, on and back."""
    return np.full((world.rows, 2), 1.0 if tick // 100 % 2 == 0 else -1.0)


def into_a_clump(world, rng, tick, wheels):
    return towards(world, 0.0, 0.0)


def into_a_corner(world, rng, tick, wheels):
    return towards(world, 0.5 * world.scenario.arena.length, 0.5 * world.scenario.arena.width)


FORAGERS = [
    name
    for name in CONTROLLERS
    if CONTROLLERS[name].supports(Scenario())
    and not {"motion.policy", "policy.file"} & CONTROLLERS[name].parameters.keys()
]  # a trained motion is for so many messages at a time as it was trained on
DRIVERS = (at_random, straight, into_a_clump, into_a_corner, *FORAGERS)


def swarm(scenario, driver, physics, seed):
    """The world, and what makes one tick of it."""
    name = driver if isinstance(driver, str) else "dsgiff"
    loop = Loop(scenario, find_controller(name), [seed], physics)
    if isinstance(driver, str):
        return loop.world, lambda tick: loop.step()
    world, rng = loop.world, np.random.default_rng(seed)
    wheels = np.zeros((world.rows, 2))
    share = scenario.robot.max_speed / scenario.robot.cruise_speed

    def step(tick):
        nonlocal wheels
        wheels = driver(world, rng, tick, wheels)
        command = world.state.command
        command.wheels[:], command.is_speaking[:] = wheels * share, True
        world.tick(0, 1)

    return world, step


A_FEW = settings(
    max_examples=20,
    phases=[Phase.explicit, Phase.generate],  # an example takes a second: no shrinking
    suppress_health_check=[HealthCheck.too_slow],
)
"""How a property of whole swarms is tried."""


def check(world):
    pose, scenario = world.state.pose, world.scenario
    assert np.isfinite(pose).all()
    for record in ("readings", "heard", "command"):
        for name, numbers in columns(world.robots[record], record):
            assert np.isfinite(numbers).all(), name
    inside = 0.5 * np.array([scenario.arena.length, scenario.arena.width]) - scenario.robot.radius
    assert np.all(np.abs(pose[:, :2]) <= inside + 1e-9)
    assert 2.0 * scenario.robot.radius - pdist(pose[:, :2]).min(initial=np.inf) < OVERLAP


@pytest.mark.parametrize("physics", list(ENGINES))
@A_FEW
@given(scenario=scenarios(), driver=st.sampled_from(DRIVERS), seed=st.integers(0, 2**64 - 1))
def test_a_swarm_stays_real_for_a_thousand_ticks(physics, scenario, driver, seed):
    world, step = swarm(scenario, driver, physics, seed)
    for tick in range(TICKS):
        step(tick)
        if tick % 10 == 0:
            check(world)
    check(world)


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
def cluttered(draw):
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


AGAINST_WALLS = (at_random, straight, into_a_clump, into_the_first, into_a_corner_of_the_outer_wall)


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
@given(
    scenario=cluttered(),
    driver=st.sampled_from((*AGAINST_WALLS, "ssgikf", "dsgiff")),
    seed=st.integers(0, 2**64 - 1),
)
def test_nobody_is_inside_or_beyond_a_wall(physics, scenario, driver, seed):
    world, step = swarm(scenario, driver, physics, seed)
    for tick in range(600):
        step(tick)
        if tick % 5 == 0:
            check(world)
            check_obstacles(world)
