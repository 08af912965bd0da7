"""Commands and weights that are not finite end the episode, and nothing of it is kept."""

import numpy as np
import pytest

from baselines.controller import LayeredController
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario


class NaNAfter:
    """A motion that stands still, and after so many ticks commands what is no number."""

    def __init__(self, ticks):
        self.ticks = ticks

    def start(self, scenario, seeds):
        return self

    def reset(self, world, seed):
        self.left = self.ticks

    def __call__(self, situation, readings, heard, wheels):
        self.left -= 1
        wheels = np.zeros_like(wheels)
        wheels[3, 1] = np.nan if self.left < 0 else 0.0
        return wheels


class NaNWeights:
    heard_p_share = 1.0

    def __call__(self, exchange):
        return np.full(exchange.own_p.shape, np.nan, np.float32)


@pytest.mark.parametrize("threads", [1, 2])
def test_wheels_that_are_not_finite_are_told_with_controller_tick_and_robot(threads):
    controller = LayeredController(
        "mine", SocialOdometryParameters(), find_layered_controller("ssgikf").weighting, NaNAfter(7)
    )
    loop = Loop(find_scenario("es1"), controller, [0, 1], "kinematic", threads)
    run(loop, 7)
    with pytest.raises(ConfigError, match=r"'mine', tick 8, robot 3: its wheels \[0.0, nan\]"):
        loop.step()


def test_weights_that_are_not_finite_are_told():
    controller = LayeredController(
        "mine", SocialOdometryParameters(), NaNWeights(), SubsumptionParameters()
    )
    scenario = find_scenario("es1", {"task.area_distance": 0.7})
    loop = Loop(scenario, controller, range(4), "kinematic")
    with pytest.raises(ConfigError, match=r"'mine', tick \d+, robot \d: .* weights are not finite"):
        run(loop, 3000)


def run(loop, ticks):
    for _ in range(ticks):
        loop.step()


def test_accelerations_of_waypoint_robots_are_checked():
    controller = find_layered_controller("boids-adaptive")
    scenario = find_scenario("waypoints-05")
    loop = Loop(scenario, controller, [0])
    loop.world.robots["action"]["motion"] = 1
    loop.world.robots["action"]["acceleration"][0, 2] = np.inf
    with pytest.raises(ConfigError, match=r"tick 1, robot 2: its acceleration \[inf, inf\]"):
        loop.step()
