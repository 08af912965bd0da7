"""Boids: gains worked by hand, and a pull that depends on nothing but the situation."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError

from baselines.motion.boids import BoidsParameters
from baselines.motion.flock import adaptive_gains
from swarm_forage_env.record import numbers_record
from swarm_forage_env.record import rows as as_rows
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.records import Readings, Situation

SCENARIO = find_scenario("waypoints-05")
RULES = ("alignment", "separation", "centre", "home", "goal")
VECTORS = (*RULES, "velocity")
STIMULI = ("density", "covariance_norm", "dead_reckoning_offset")


def situation(rows=1, **changed):
    """One of robots that believe nothing, with some of it changed."""
    records = as_rows(Situation.array((rows,)))
    for name, value in changed.items():
        records[name] = value
    return records


def anywhere(seed, rows=1, **changed):
    rng = np.random.default_rng(seed)
    vectors = {name: rng.normal(size=(rows, 2)) for name in VECTORS}
    vectors["velocity"] *= 0.3
    stimuli = {name: rng.uniform(0.0, 1.5, rows) for name in STIMULI}
    return situation(rows, **{**vectors, **stimuli, **changed})


def pull(seen, **parameters):
    """The acceleration that boids command in each situation."""
    layer = BoidsParameters(**parameters).layer(SCENARIO)
    numbers = np.zeros(1, numbers_record(**layer.numbers))
    for name, value in layer.numbers.items():
        numbers[name] = value
    memory, readings = (as_rows(kind.array((1,)))[0] for kind in (layer.memory, Readings))
    found = np.full((len(seen), 2), 9.0, np.float32)
    for each, acceleration in zip(seen, found, strict=True):
        layer.steer(each, readings, acceleration, memory, as_rows(numbers)[0])
    return found


def unit(v):
    size = np.linalg.norm(v)
    return v / size if size > 0.0 else np.zeros(2)


def total(s, gains):
    """The weighted sum of all forces on one robot."""
    forces = np.zeros(2)
    for gain, name in zip(gains, RULES, strict=True):
        way = s[name][0].astype(float)
        if way.any() and not (name == "goal" and s.has_arrived[0]):
            forces += gain * unit(0.5 * unit(way) - s.velocity[0])
    return forces


def adapted(s):
    """The gains of a situation; the distances to goal and home are shares of the side."""
    distances = [np.linalg.norm(way[0]) / SCENARIO.task.side for way in (s.goal, s.home)]
    return gains_of(*(s[name][0] for name in STIMULI), *distances)


def gains_of(*stimuli):
    gains = np.full(5, 9.0)
    adaptive_gains(*stimuli, gains)
    return gains


@pytest.mark.parametrize(
    ("stimuli", "gains"),
    [
        ((0.0, 0.0, 0.0, 0.0, 0.0), (1.0, 3.0, 0.0, 1.0, 3.0)),
        ((0.2, 0.4, 0.1, 0.3, 0.25), (1.05, 2.2, 0.75, 1.25, 2.2)),
        ((1.0, 1.0, 1.0, 1.0, 1.0), (2.0, 0.0, 3.0, 2.0, 0.0)),
        ((0.0, 3.0, 0.5, 0.5, 0.0), (1.5, -1.0, 3.5, 4.5, -1.0)),
    ],
)
def test_adaptive_gains_are_those_of_the_paper_and_are_not_clamped(stimuli, gains):
    assert_allclose(gains_of(*stimuli), gains, atol=1e-12)


@pytest.mark.parametrize(
    "wrong", [{"gains": "best"}, {"alignment": -0.1}, {"cohesion": 1e300}, {"homming": 1.0}]
)
def test_gains_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValidationError):
        BoidsParameters(**wrong)


STATIC = {"alignment": 0.3, "separation": 0.5, "cohesion": 0.7, "homing": 1.1, "seeking": 1.3}


@pytest.mark.parametrize("gains", ["goal", "static", "adaptive"])
@pytest.mark.parametrize("seed", range(20))
def test_gains_weigh_the_rules_and_who_has_arrived_ignores_its_goal(seed, gains):
    s = anywhere(seed, has_arrived=seed % 4 == 0)
    weighed = {"goal": (0, 0, 0, 0, 1), "static": STATIC.values(), "adaptive": adapted(s)}[gains]
    found = pull(s, gains=gains, **STATIC)[0]
    assert_allclose(found, unit(total(s, weighed)), atol=1e-5)
