"""The built-in rule, driven from outside by its observation, repeats the built-in run exactly."""

from itertools import product
from typing import Literal, get_args, get_origin

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.controller import LayeredController
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion import MOTIONS
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.rows import RowWeighting
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.loop import Loop
from tests.commands import parallel_env
from tests.outside import OutsideMotion, motion_inputs, shown_records

TICKS = 3000
SEED = 7


def choices(part):
    """The part under its defaults, and under every value of every literal parameter."""
    found = [part()]
    for name, of in part.model_fields.items():
        if get_origin(of.annotation) is Literal:
            found += [part(**{name: value}) for value in get_args(of.annotation)]
    return list(dict.fromkeys(found))


def cases(registry):
    """Every part of a registry that is made for foraging and is not the estimator's own."""
    return [
        pytest.param(part, id=f"{name}-{k}")
        for name in registry
        if "foraging" in getattr(registry[name], "tasks", ("foraging",)) and name != "filter"
        for k, part in enumerate(choices(registry[name]))
    ]


def weighting_of(part, scenario):
    """A rule as a function of the records that an observation shows, compiled or not."""
    rule = RowWeighting(part.layer(scenario)) if hasattr(part, "layer") else part
    return lambda seen: rule(seen["exchange"])


def motion_of(part, scenario):
    """A motion as a function of the records that an observation shows."""
    motion = OutsideMotion(part.layer(scenario), scenario, [SEED])
    return lambda seen: motion(*motion_inputs(seen))


def assert_same_run(learn, scenario, recipe, decide, residual=False, ticks=TICKS):
    """Drive one layer by `decide(records shown)` as the loop does; the loop, and its exchanges."""
    loop = Loop(scenario, recipe, [SEED])
    env = parallel_env(scenario, learn=learn, controller=recipe, residual=residual)
    observations, _ = env.reset(seed=SEED)
    exchanges = 0
    for tick in range(ticks):
        actions = decide(shown_records(env.observation_layout, observations))
        observations, *_ = env.step(dict(zip(env.agents, actions, strict=True)))
        loop.step()
        exchanges += np.count_nonzero(loop.exchange.is_valid)
        assert (env.world.state.pose == loop.world.state.pose).all(), f"they part at tick {tick}"
    ours, theirs = env.array_env.loop.controller, loop.controller
    for name in {"belief", "reckoned"}.intersection(theirs.minds["estimator"].dtype.names):
        assert_array_equal(ours.minds["estimator"][name], theirs.minds["estimator"][name], name)
    assert_array_equal(ours.shared, theirs.shared)
    for name in set(loop.world.robots.dtype.names) - {"action"}:
        assert_array_equal(env.world.robots[name], loop.world.robots[name], name)
    return loop, exchanges


@pytest.mark.parametrize("rule", cases(WEIGHTING_RULES))
def test_a_weighting_rule_from_outside_is_the_rule_inside(rule, busy):
    estimator = SocialOdometryParameters(double=True)
    recipe = LayeredController("inside", estimator, rule, SubsumptionParameters())
    loop, exchanges = assert_same_run("weighting", busy, recipe, weighting_of(rule, busy))
    assert exchanges > 100
    assert loop.world.state.round_trips.sum() > 0


@pytest.mark.parametrize("parameters", cases(MOTIONS))
def test_a_motion_from_outside_is_the_motion_inside(parameters, busy):
    recipe = LayeredController("inside", SocialOdometryParameters(), SGIKF(), parameters)
    _, exchanges = assert_same_run("motion", busy, recipe, motion_of(parameters, busy))
    assert exchanges > 50


@pytest.mark.parametrize(
    ("learn", "residual"), [("both", False), *product(FORAGING.residuals, [True])]
)
def test_both_layers_and_residuals_of_zero_from_outside_are_those_inside(learn, residual, busy):
    rule, parameters = SGIKF(), SubsumptionParameters()
    recipe = LayeredController("inside", SocialOdometryParameters(double=False), rule, parameters)
    weigh, motion = weighting_of(rule, busy), motion_of(parameters, busy)

    def decide(seen):
        weights = [weigh(seen)] if learn == "both" else []
        wheels = np.zeros((10, 2), np.float32) if residual else motion(seen)
        return np.concatenate([*weights, wheels], axis=1)

    _, exchanges = assert_same_run(learn, busy, recipe, decide, residual=residual)
    assert exchanges > 100
