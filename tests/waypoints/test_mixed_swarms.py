"""Robots that visit waypoints by different motions and weightings, with one estimator."""

from dataclasses import replace

import numpy as np
import pytest

import baselines.controllers  # noqa: F401 enters the controllers
from swarm_forage_env.loop import Loop
from swarm_forage_env.mixed import MixedController
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.outside import OutsideMotionPart

ADAPTIVE = CONTROLLERS["boids-adaptive"]
SCENARIO = find_scenario("waypoints-25")


class Whole:
    """Every correction is carried out, as a weighting in NumPy."""

    tasks = ("waypoints",)
    heard_p_share = 0.0

    def __call__(self, exchange):
        return np.ones((len(exchange), 1), np.float32)


def mixed(*controllers):
    n_robots = SCENARIO.task.n_robots
    return MixedController(tuple(controllers[i % len(controllers)] for i in range(n_robots)))


def run(controller, ticks=60):
    loop = Loop(SCENARIO, controller, [3, 4])
    loop.run(ticks)
    return loop


@pytest.mark.parametrize("estimator", ["decentralised_ekf", "covariance_intersection"])
def test_the_same_layers_compiled_and_in_numpy_in_one_swarm_are_the_uniform_swarm(estimator):
    compiled = ADAPTIVE.with_parameters({"estimator": estimator})
    swarm = mixed(
        compiled,
        replace(compiled, weighting=Whole()),
        replace(compiled, motion=OutsideMotionPart(compiled.motion, ("waypoints",))),
    )
    one, other = run(compiled), run(swarm)
    np.testing.assert_array_equal(one.world.robots["pose"], other.world.robots["pose"])
    beliefs = (loop.controller.minds["estimator"]["belief"] for loop in (one, other))
    np.testing.assert_array_equal(*beliefs)
    np.testing.assert_array_equal(one.controller.shared, other.controller.shared)
    assert np.abs(one.world.sightings["seen"]).sum() > 0


def test_every_robot_goes_by_its_own_gains():
    goal, static = (CONTROLLERS[name] for name in ("boids-goal", "boids-static"))
    first = [run(each, 1).world.robots["command"]["acceleration"] for each in (goal, static)]
    both = run(mixed(goal, static), 1).world.robots["command"]["acceleration"]
    np.testing.assert_array_equal(both[:, ::2], first[0][:, ::2])
    np.testing.assert_array_equal(both[:, 1::2], first[1][:, 1::2])
    assert np.any(first[0] != first[1])
