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

WORLDS = {
    ("es1", "kinematic"): ("ssgikf", 700),
    ("es1", "rigid"): ("ssgiff", 400),
    ("two-prey", "kinematic"): ("dsgikf", 200),
    ("mg1-hexagon", "kinematic"): ("ssgikf", 100),
    ("mg1-hexagon", "rigid"): ("nc", 100),
    ("waypoints-05", "kinematic"): ("boids-adaptive", 500),
}
"""A scenario and an engine, a controller, and how many scenarios like it where FAULTS is 100."""

TICKS = 200
WIDEST_OVERLAP = 0.001
MAX_ROBOTS = 300
"""A larger swarm takes long, and shows nothing that this one does not."""

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
    """A number up to three times as large or small; one in five up to a thousand times."""
    found = value * (1000.0 if rng.random() < 0.2 else 3.0) ** rng.uniform(-1, 1)
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


def run(scenario, controller, seed, engine, ticks=TICKS):
    """Run a scenario, and check its poses in every tick."""
    loop = Loop(scenario, find_controller(controller), [seed], engine)
    for _ in range(min(ticks, scenario.n_ticks)):
        loop.step()
        check(loop, scenario)


@pytest.mark.parametrize(("name", "engine"), WORLDS)
def test_random_scenarios_run_soundly(name, engine, tries, rng, tell):
    controller, times = WORLDS[name, engine]
    numbers, ran, refused = numbers_of(name), 0, 0
    while ran < tries(times):
        paths = rng.sample(sorted(numbers), rng.randint(1, 6))
        changes = {path: changed(numbers[path], rng) for path in paths}
        try:
            scenario = find_scenario(name, changes)
        except ConfigError:
            refused += 1
            continue
        if scenario.task.n_robots > MAX_ROBOTS:
            continue
        seed = rng.randrange(2**32)
        try:
            run(scenario, controller, seed, engine)
        except ConfigError:  # no room at the start, of this seed
            refused += 1
        except Exception as error:
            raise AssertionError(f"{name}, {engine}, seed {seed}, {changes}") from error
        ran += 1
    tell(ran=ran, refused=refused, failed=0)


@pytest.mark.parametrize("name", ["es1", "waypoints-05"])
def test_nonsense_is_accepted_or_refused_in_one_line(name, tries, rng, tell):
    numbers, refused, accepted = sorted(numbers_of(name)), [], 0
    while len(refused) < tries(1000):
        changes = {path: rng.choice(NONSENSE) for path in rng.sample(numbers, rng.randint(1, 3))}
        try:
            scenario = find_scenario(name, changes)
        except ConfigError as refusal:
            refused.append(str(refusal))
            continue
        accepted += 1
        controller, seed = WORLDS[name, "kinematic"][0], rng.randrange(2**32)
        try:
            run(scenario, controller, seed, "kinematic", ticks=20)
        except Exception as error:
            raise AssertionError(f"{name}, seed {seed}, {changes}") from error
    assert not [each for each in refused if "\n" in each]
    tell(tried=len(refused) + accepted, refused=len(refused), failed=0)
