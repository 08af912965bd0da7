"""Random scenarios: those that are valid run soundly, and all others are refused in one line."""

import math

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import leaves
from swarm_forage_env.scenarios import find_scenario

pytestmark = pytest.mark.faults

WORLDS = {"es1": "ssgikf", "waypoints-05": "boids-adaptive"}
"""A scenario of each task, and a controller."""

TICKS = 200
WIDEST_OVERLAP = 0.001

NONSENSE = (
    0, -1, 1e-308, 1e-200, 1e12, 1e13, 1e308, math.inf, -math.inf, math.nan, "x", "", None, [], {},
    True, 2**63, 10**400, 0.5,
)  # fmt: skip


def numbers_of(name):
    return {
        path: value
        for path, value in leaves(find_scenario(name).model_dump()).items()
        if isinstance(value, int | float)
    }


def changed(value, rng):
    """A number up to three times as large or small."""
    found = value * 3.0 ** rng.uniform(-1, 1)
    return max(1, round(found)) if isinstance(value, int) else found


def check(loop, scenario):
    """Poses are finite; where there are walls nobody is outside and no bodies overlap."""
    poses = loop.world.robots["pose"][0]
    assert np.isfinite(poses).all()
    if hasattr(scenario, "arena"):
        radius = scenario.robot.radius
        walls = np.array([scenario.arena.length, scenario.arena.width]) / 2 - radius
        assert (np.abs(poses[:, :2]) <= walls + 1e-6).all()
        if len(poses) > 1:
            assert 2 * radius - pdist(poses[:, :2]).min() < WIDEST_OVERLAP


@pytest.mark.parametrize("engine", ["kinematic", "rigid"])
@pytest.mark.parametrize("name", WORLDS)
def test_random_scenarios_run_soundly(name, engine, tries, rng, tell):
    if name != "es1" and engine == "rigid":
        pytest.skip("waypoints have one engine")
    numbers, ran, refused = numbers_of(name), 0, 0
    while ran < tries(4):
        paths = rng.sample(sorted(numbers), rng.randint(1, 6))
        try:
            scenario = find_scenario(name, {path: changed(numbers[path], rng) for path in paths})
        except ConfigError:
            refused += 1
            continue
        loop = Loop(scenario, find_controller(WORLDS[name]), [rng.randrange(2**32)], engine)
        for _ in range(min(TICKS, scenario.n_ticks)):
            loop.step()
            check(loop, scenario)
        ran += 1
    tell(ran=ran, refused=refused, failed=0)


@pytest.mark.parametrize("name", WORLDS)
def test_nonsense_is_accepted_or_refused_in_one_line(name, tries, rng, tell):
    numbers, refusals = sorted(numbers_of(name)), []
    for _ in range(10 * tries()):
        paths = rng.sample(numbers, rng.randint(1, 3))
        try:
            find_scenario(name, {path: rng.choice(NONSENSE) for path in paths})
        except ConfigError as refusal:
            refusals.append(str(refusal))
    assert not [each for each in refusals if "\n" in each]
    tell(tried=10 * tries(), refused=len(refusals), failed=0)
