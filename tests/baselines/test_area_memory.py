"""Social odometry: where a robot believes it is, finds an area, and gets lost."""

import math

import numpy as np
import pytest

from baselines.estimators.area_memory import NEST_BELOW, PREY_BELOW, area_under
from baselines.estimators.belief import NOWHERE
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.interface import REPLACE
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.beliefs import localisation_error


@pytest.mark.parametrize(
    ("ground", "area"),
    [
        ((1.0, 1.0, 1.0), NOWHERE),
        ((0.7, 0.7, 1.3), NOWHERE),  # the darkest that the floor is read
        ((0.65, 0.35, 0.5), PREY),  # the brightest and darkest that the prey area is read
        ((0.0, 0.0, 0.0), NEST),
        ((0.0, 0.0, 1.0), NEST),
        ((0.0, 1.0, 1.0), NOWHERE),
        ((0.5, 1.0, 0.5), PREY),
        ((NEST_BELOW, NEST_BELOW, 0.0), PREY),  # a limit belongs to what is brighter
        ((PREY_BELOW, PREY_BELOW, 0.0), NOWHERE),
    ],
)
def test_two_of_three_ground_sensors_decide(ground, area):
    assert area_under(np.array(ground, np.float32)) == area


def walk_until_lost(robot, step=0.01, ticks=500):
    """Straight on over white floor; how far the robot was when it reported itself lost."""
    for tick in range(1, ticks):
        robot.sense(distance=step)
        if robot.lost[0]:
            return tick * step
    return math.inf


def test_who_looked_in_vain_is_lost_forgets_both_areas_and_hears_nothing(believers, message):
    # TR 5.1
    robot = believers(2, lost_within=0.05, overshoot=0.2, deaf_when_lost=1.0)
    robot.know(0, PREY, 1.0, 0.0, p=1.0, visited=False)
    robot.sense(ground="nest")
    assert robot.beliefs.visited[0].tolist() == [1, 0]
    assert walk_until_lost(robot) == pytest.approx(1.0 - 0.05 + 0.2, abs=0.03)
    assert not robot.beliefs.known[0].any()
    assert not robot.beliefs.visited[0].any()
    assert robot.beliefs.goal[0] == NOWHERE
    told = [(0, 1, message(nest=(0.7, 0.3, 1.2)), (0.1, 0.0, 0.0))]
    talking = []
    for _ in range(11):
        robot.sense(messages=told)
        talking.append(robot.talking[0])
    assert talking == [False] * 9 + [True] * 2
    assert not any(robot.lost)


def beliefs_of(loop):
    """What every robot of a block believes, a row for each."""
    return rows(loop.controller.minds["estimator"]).belief


EXACT = {"wheel_noise": 0.0, "ground_noise": 0.0, "n_robots": 1, "area_distance": 1.0}


@pytest.mark.parametrize("area", [NEST, PREY])
def test_exact_encoders_find_a_centre_that_is_headed_for_within_a_tick(area):
    scenario = find_scenario("es1", EXACT)
    loop = Loop(scenario, CONTROLLERS["nc"], [0], "kinematic")
    x, y = loop.world.areas[area]
    loop.world.state.pose[:] = [x + 0.3 * math.cos(1.0), y + 0.3 * math.sin(1.0), 1.0 - math.pi]
    beliefs, action = beliefs_of(loop), loop.world.state.action
    action.motion[:], action.wheels[:] = REPLACE, 1.0
    while not beliefs.known[0, area]:
        loop.step()
    assert localisation_error(loop)[0, area] <= scenario.robot.cruise_speed * scenario.tick + 1e-6
