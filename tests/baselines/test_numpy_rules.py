"""Rules in NumPy from outside: they repeat the compiled ones, and end an episode by a NaN."""

from dataclasses import replace

import numpy as np
import pytest

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import CORRECT, KEEP, REPLACE, RULE
from swarm_forage_env.loop import Loop
from swarm_forage_env.mixed import MixedController
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.outside import OutsideMotionPart, SGIKFInNumPy

ENGINES = ("rigid", "kinematic")
TICKS = 600


class Constant:
    """A motion that commands the same wheels to all, and notes what it was asked."""

    wheels = 1.0, 0.8

    def start(self, scenario, seeds):
        self.resets, self.asked = [], 0
        return self

    def reset(self, world, seed):
        self.resets.append((world, seed))

    def __call__(self, situation, readings, heard, wheels):
        self.asked += 1
        return np.resize(np.array(self.wheels, np.float32), (len(situation.goal), 2))


COMPILED = CONTROLLERS["dsgikf"]
WEIGHS_IN_NUMPY = replace(COMPILED, weighting=SGIKFInNumPy())
MOVES = {"motion": OutsideMotionPart(SubsumptionParameters())}
EACH_WAY = COMPILED, replace(COMPILED, **MOVES), WEIGHS_IN_NUMPY, replace(WEIGHS_IN_NUMPY, **MOVES)


@pytest.mark.parametrize("physics", ENGINES)
@pytest.mark.parametrize(
    "rules",
    [WEIGHS_IN_NUMPY, MixedController(tuple(EACH_WAY[robot % 4] for robot in range(10)))],
    ids=["all", "some"],
)
def test_rules_in_numpy_are_the_compiled_ones_bit_for_bit(busy, physics, rules):
    one, other = (
        Loop(busy, controller, [0, 1, 2], physics, threads=2) for controller in (COMPILED, rules)
    )
    for loop in (one, other):
        loop.world.robots["action"]["motion"][:, 3] = CORRECT
        loop.world.robots["action"]["wheels"][:, 3] = 0.1
        loop.run(TICKS)
    np.testing.assert_array_equal(one.world.robots["pose"], other.world.robots["pose"])
    mine, theirs = (loop.controller.minds["estimator"] for loop in (one, other))
    for name in ("belief", "message", "situation"):
        np.testing.assert_array_equal(mine[name], theirs[name], err_msg=name)
    assert mine["exchange"]["weight"].any()


@pytest.mark.parametrize("physics", ENGINES)
def test_a_motion_from_outside_is_handed_to_the_wheels_unless_a_learner_goes_before(busy, physics):
    motion = Constant()
    controller = replace(CONTROLLERS["dsgikf"], motion=motion)
    loop = Loop(busy, controller, [4, 5], physics)
    action, command = loop.world.state.action, loop.world.state.command
    action.motion[0], action.wheels[0] = REPLACE, -0.5
    loop.step()
    assert command.wheels[0].tolist() == [-0.5, -0.5]
    assert np.all(command.wheels[1:] == np.float32(Constant.wheels))
    assert action.motion.tolist() == [REPLACE] + [RULE] * 19
    action.motion[0] = KEEP
    loop.run(19)
    assert np.all(command.wheels == np.float32(Constant.wheels))
    assert motion.asked == 20
    loop.reset([6, 7])
    assert motion.resets == [(0, 4), (1, 5), (0, 6), (1, 7)]


@pytest.mark.parametrize("threads", [1, 2])
def test_wheels_that_are_not_finite_are_told_with_controller_tick_and_robot(threads):
    motion = Constant()
    controller = replace(CONTROLLERS["ssgikf"], motion=motion)
    loop = Loop(find_scenario("es1"), controller, [0, 1], "kinematic", threads)
    loop.run(7)
    motion.wheels = np.ones((10, 2))
    motion.wheels[3, 1] = np.nan
    with pytest.raises(ConfigError, match=r"'ssgikf', tick 8, robot 3: its wheels \[1.0, nan\]"):
        loop.step()


def test_weights_that_are_no_numbers_of_each_robot_are_told():
    scenario = find_scenario("es1", {"task.area_distance": 0.7})
    for weights, told in {
        lambda p: np.nan * p: r"'ssgikf', tick \d+, robot \d: .* a weight is not from 0 to 1",
        lambda p: np.full_like(p, 1.5): "a weight is not from 0 to 1; correct the layer or policy",
        lambda p: 0.5 * p.T: r"function: gave shape \(2, 40\), must be \(40, 2\), a row for each",
    }.items():

        def rule(exchange, weights=weights):
            return weights(exchange.own_p)

        rule.heard_p_share = 1.0
        controller = replace(CONTROLLERS["ssgikf"], weighting=rule)
        with pytest.raises(ConfigError, match=told):
            Loop(scenario, controller, range(4), "kinematic").run(3000)


def test_accelerations_of_waypoint_robots_are_checked():
    loop = Loop(find_scenario("waypoints-05"), CONTROLLERS["boids-adaptive"], [0])
    loop.world.robots["action"]["motion"] = REPLACE
    loop.world.robots["action"]["acceleration"][0, 2] = np.inf
    with pytest.raises(ConfigError, match=r"tick 1, robot 2: its acceleration \[inf, inf\]"):
        loop.step()
