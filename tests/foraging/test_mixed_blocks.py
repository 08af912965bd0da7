"""Blocks in which every world has its own numbers: each is that world alone."""

from dataclasses import replace

import pytest

from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting.sikf import SIKF
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.outside import OutsideMotionPart, SGIKFInNumPy
from tests.worlds import check_each_is_itself

BUSY = {"cruise_speed": 0.12, "area_distance": 0.7, "wheel_noise": 0.02, "duration": 60.0}
AREAS = (
    {"kind": "nest", "centre": [-0.35, 0.0]},
    {"centre": [0.35, 0.0], "moves_at": 20.0, "moves_to": [0.6, 0.0]},
    {"centre": [0.6, 0.4], "worth": 0.5},
)
DISC = {"points": [[0.0, 0.4]], "radius": 0.1}
TRIANGLE = {"points": [[-0.3, -0.5], [0.3, -0.5], [0.0, -0.3]], "is_closed": True}
WORLDS = (
    ("es1", {**BUSY}),
    ("es1", {**BUSY, "max_range": 0.3, "loss_far": 0.2, "frames": 5}),
    ("es1", {**BUSY, "area_distance": 0.9, "area_radius": 0.15, "wheel_noise": 0.2}),
    ("es1", {**BUSY, "arena.length": 1.2, "arena.width": 0.9, "slots": 1}),
    ("es1", {**BUSY, "tick": 0.2, "exchange_time": 1.0, "duration": 90.0}),
    ("real", {**BUSY, "axle": 0.06, "radius": 0.03, "proximity_noise": 0.4}),
    ("es1", {"cruise_speed": 0.12, "task.areas": AREAS, "obstacles": (TRIANGLE, DISC)}),
    ("es1", {**BUSY, "obstacles": (DISC,), "is_shadowed": True, "faults.liar.share": 0.3}),
)
NUMBERS = (
    {},
    {"beta": 0.1},
    {"beta": 0.001, "refractory": 2.0, "pause": 0.5},
    {"gap": 0.03, "hold": 0.5, "mean_run": 0.1},
    {"overshoot": 0.1, "lost_within": 0.1, "double": False},
    {"avoidance": "literal", "message_path": 1.0, "listens_above": 0.5},
    {"beta": 0.02},
    {},
)
SEEDS = (4, 9, 2, 7, 1, 5, 8, 3)


@pytest.fixture(scope="module")
def world_of():
    """The scenario and the controller of each world."""
    scenarios = [find_scenario(name, numbers) for name, numbers in WORLDS]
    controllers = [CONTROLLERS["dsgiff"].with_parameters(numbers) for numbers in NUMBERS]
    return scenarios, controllers


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
@pytest.mark.parametrize("order", [range(8), (3, 7, 5, 4, 6, 1, 2, 0)])
def test_each_world_of_a_mixed_block_is_the_world_alone(world_of, physics, order):
    scenarios, controllers, seeds = ([each[w] for w in order] for each in (*world_of, SEEDS))
    block = check_each_is_itself(scenarios, controllers, seeds, physics, 250)
    assert (block.world.robots["messages"].sum(axis=1) > 0).all()


def test_one_scenario_or_controller_for_each_world_is_asked_for(world_of):
    scenarios, controllers = world_of
    with pytest.raises(ConfigError, match="2 given for 3 worlds"):
        Loop(scenarios[:2], controllers[0], [0, 1, 2])
    with pytest.raises(ConfigError, match="2 given for 3 worlds"):
        Loop(scenarios[0], controllers[:2], [0, 1, 2])


@pytest.mark.parametrize(
    ("scenario", "controller"), [("es1", "nc"), ("waypoints-05", "boids-adaptive")]
)
def test_worlds_with_other_numbers_of_robots_are_refused(scenario, controller):
    scenarios = [find_scenario(scenario, {"n_robots": n}) for n in (10, 8)]
    with pytest.raises(ConfigError, match="n_robots"):
        Loop(scenarios, CONTROLLERS[controller], [0, 1])


class Outside(OutsideMotionPart):
    """A motion from outside that says so by a layer of None."""

    def layer(self, scenario):
        return None


def with_a_motion():
    return replace(NC, motion=Outside(SubsumptionParameters()))


NC = CONTROLLERS["nc"]
WITH_A_RULE = replace(NC, weighting=SGIKFInNumPy())


@pytest.mark.parametrize(
    ("first", "other", "layer"),
    [
        (NC, CONTROLLERS["ssgiff"], "weighting"),
        (NC, replace(NC, weighting=SIKF()), "weighting"),
        (NC, WITH_A_RULE, "weighting"),
        (WITH_A_RULE, replace(NC, weighting=SGIKFInNumPy()), "weighting"),
        (with_a_motion(), with_a_motion(), "motion"),
    ],
)
def test_worlds_with_other_layers_are_refused(first, other, layer):
    Loop(find_scenario("es1"), [first, first], [0, 1]).step()
    with pytest.raises(ConfigError, match=f"differ in their {layer}"):
        Loop(find_scenario("es1"), [first, other], [0, 1])


class Misspelt(SocialOdometryParameters):
    kernels = KERNELS | {"merg": KERNELS["merge"]}


def test_a_function_of_a_layer_that_the_tick_does_not_call_is_refused():
    with pytest.raises(UnknownNameError, match="named 'merg', did you mean 'merge'"):
        Loop(find_scenario("es1"), replace(NC, estimator=Misspelt()), [0])
