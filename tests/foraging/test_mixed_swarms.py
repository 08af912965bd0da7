"""Robots of different controllers in one world: each goes by its own layers and numbers."""

from dataclasses import replace

import numpy as np
import pytest

import baselines.oracles.controllers  # noqa: F401 enters the references
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.interface import CORRECT, KEEP, REPLACE
from swarm_forage_env.loop import Loop
from swarm_forage_env.mixed import MixedController
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario
from tests.outside import OutsideMotionPart, SGIKFInNumPy
from tests.worlds import check_each_is_itself

BUSY = {"cruise_speed": 0.12, "area_distance": 0.7, "wheel_noise": 0.02, "duration": 60.0}
N = 10
OUTSIDE = OutsideMotionPart(SubsumptionParameters())


def named(name, **values):
    return CONTROLLERS[name].with_parameters(values)


def mixed(*controllers):
    """The controllers in turn, one for each of ten robots."""
    return MixedController(tuple(controllers[robot % len(controllers)] for robot in range(N)))


def busy(**numbers):
    return find_scenario("es1", BUSY | numbers)


def companies():
    """Swarms of several kinds of difference."""
    dsgiff = named("dsgiff")
    return {
        "numbers": mixed(dsgiff, named("dsgiff", beta=0.5, pause=1.0), named("dsgiff", gap=0.03)),
        "weightings": mixed(dsgiff, named("dsgikf"), named("ssgikf")),
        "rules in NumPy": mixed(
            dsgiff,
            replace(dsgiff, motion=OUTSIDE),
            replace(dsgiff, motion=OUTSIDE, weighting=SGIKFInNumPy()),
        ),
        "estimators": mixed(dsgiff, named("sikf"), named("subsumption"), named("boids-adaptive")),
        "a policy": mixed(FORAGING.raw_control, dsgiff, named("sikf")),
    }


@pytest.mark.parametrize("swarm", companies().values(), ids=companies())
def test_a_mixed_world_in_a_block_is_the_world_alone(swarm):
    check_each_is_itself(busy(), swarm, [1, 2, 3], "kinematic", 150)


def test_a_learner_acts_in_a_mixed_swarm_as_in_a_uniform_one():
    swarm = mixed(named("dsgiff"), named("sikf"), replace(named("dsgiff"), motion=OUTSIDE))
    one, other = (Loop(busy(), swarm, [4], "kinematic") for _ in range(2))
    for each in (one, other):
        each.run(100)
    action = other.world.state.action
    action.motion[:3], action.wheels[:3] = REPLACE, (-0.5, 0.25)
    action.motion[3:5], action.wheels[3:5] = CORRECT, (0.1, -0.1)
    talking = other.situation.is_talking
    one.step()
    other.step()
    wheels = one.world.state.command.wheels.copy()
    wheels[:3] = -0.5, 0.25
    added = np.clip(wheels[3:5] + np.float32(2.0) * np.float32([0.1, -0.1]), -1.0, 1.0)
    wheels[3:5] = np.where(talking[3:5, None], wheels[3:5], added)
    np.testing.assert_array_equal(other.world.state.command.wheels, wheels)
    action.motion[:5] = KEEP
    other.step()
    assert not np.any(np.all(other.world.state.command.wheels[:3] == np.float32([-0.5, 0.25])))


def test_worlds_of_a_block_may_have_differing_mixtures_and_uniform_swarms():
    swarms = [
        mixed(named("dsgiff"), named("dsgiff", beta=0.3)),
        mixed(named("dsgiff", pause=2.0), named("dsgiff")),
        named("dsgiff"),
    ]
    check_each_is_itself(busy(), swarms, [4, 5, 6], "kinematic")


def test_worlds_in_which_other_robots_understand_each_other_are_refused():
    swarms = [mixed(named("dsgiff"), named("sikf")), mixed(named("sikf"), named("dsgiff"), *[
        named("dsgiff")] * 8)]  # fmt: skip
    with pytest.raises(ConfigError, match="must understand each other in all worlds"):
        Loop(busy(), swarms, [4, 5])
    with pytest.raises(ConfigError, match="'ssgikf' and 'ssgiff' differ in their weighting"):
        Loop(busy(), [mixed(named("ssgikf")), mixed(named("ssgiff"))], [4, 5])


def test_an_oracle_drives_no_robots_among_others():
    with pytest.raises(ConfigError, match="'global': controls whole swarms only"):
        Loop(busy(), mixed(named("dsgiff"), REFERENCES["global"]), [4])


def test_a_swarm_of_another_size_is_refused():
    with pytest.raises(ConfigError, match="10 controllers given for the 4 robots of 'es1'"):
        Loop(busy(n_robots=4), mixed(named("dsgiff")), [4])
