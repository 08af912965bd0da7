"""A policy in the place of a layer is shown what the hand-written layer is shown.

The proof: the baseline's own rule, driven from outside through `env.step` from the observation
alone, reproduces the built-in run bit for bit.
"""

from dataclasses import fields, replace
from itertools import product
from typing import Literal, get_args, get_origin

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.controller import Recipe, made_for
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion import MOTIONS
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env import parallel_env
from swarm_forage_env.envs.bounds import Bounds
from swarm_forage_env.envs.cuts import CUTS, RESIDUAL_CUTS, corrected
from swarm_forage_env.envs.layout import ObservationLayout, Sheet
from swarm_forage_env.interface import WORDS
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.scenario import Scenario

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
    """Every part of a registry that is made for foraging."""
    return [
        pytest.param(part, id=f"{name}-{k}")
        for name in registry
        if Scenario in made_for(registry[name])
        for k, part in enumerate(choices(registry[name]))
    ]


def assert_same_run(learn, scenario, recipe, decide, residual=False):
    """Drive one layer from outside by `decide(layout, observations)`; compare with the loop."""
    loop = ControlLoop(scenario, recipe, [SEED])
    env = parallel_env(scenario, learn=learn, controller=recipe, residual=residual)
    observations, _ = env.reset(seed=SEED)
    exchanges = 0
    for tick in range(TICKS):
        matrix = np.stack(list(observations.values()))
        actions = decide(env.observation_layout, matrix)
        observations, *_ = env.step(dict(zip(env.agents, actions, strict=True)))
        loop.step()
        exchanges += np.count_nonzero(loop.controller.estimator.encounter.valid)
        assert (env.world.state.pose == loop.world.state.pose).all(), f"they part at tick {tick}"
    ours = env._batch.cut._loop.controller.estimator.beliefs
    for field in fields(ours):
        theirs = getattr(loop.controller.estimator.beliefs, field.name)
        assert_array_equal(getattr(ours, field.name), theirs, field.name)
    for field in fields(env.world.state):
        theirs = getattr(loop.world.state, field.name)
        assert_array_equal(getattr(env.world.state, field.name), theirs, field.name)
    return exchanges, int(loop.world.state.round_trips.sum())


@pytest.mark.parametrize("rule", cases(WEIGHTING_RULES))
def test_a_weighting_rule_from_outside_is_the_rule_inside(rule, busy):
    estimator = SocialOdometryParameters(double=True)
    recipe = Recipe("inside", estimator, rule, SubsumptionParameters())
    exchanges, trips = assert_same_run(
        "weighting", busy, recipe, lambda layout, matrix: rule(layout.encounter(matrix))
    )
    assert exchanges > 100
    assert trips > 0


@pytest.mark.parametrize("parameters", cases(MOTIONS))
def test_a_motion_from_outside_is_the_motion_inside(parameters, busy):
    recipe = Recipe("inside", SocialOdometryParameters(), SGIKF(), parameters)
    motion = parameters.start(busy, [SEED])
    exchanges, _ = assert_same_run(
        "motion", busy, recipe, lambda layout, matrix: motion(layout.situation(matrix))
    )
    assert exchanges > 50


def test_both_layers_from_outside_are_both_inside(busy):
    rule, parameters = SGIKF(), SubsumptionParameters()
    recipe = Recipe("inside", SocialOdometryParameters(double=False), rule, parameters)
    motion = parameters.start(busy, [SEED])

    def decide(layout, matrix):
        g = rule(layout.encounter(matrix))
        return np.concatenate([g, motion(layout.situation(matrix))], axis=1)

    exchanges, trips = assert_same_run("both", busy, recipe, decide)
    assert exchanges > 100
    assert trips > 0


@pytest.mark.parametrize("learn", list(RESIDUAL_CUTS))
def test_residuals_of_zero_are_the_hand_written_motion(learn, busy):
    rule = SGIKF()
    recipe = Recipe("inside", SocialOdometryParameters(), rule, SubsumptionParameters())

    def decide(layout, matrix):
        zeros = np.zeros((len(matrix), 2), np.float32)
        if learn == "motion":
            return zeros
        return np.concatenate([rule(layout.encounter(matrix)), zeros], axis=1)

    exchanges, _ = assert_same_run(learn, busy, recipe, decide, residual=True)
    assert exchanges > 50


def test_a_residual_is_added_twice_and_robots_that_talk_are_let_be():
    own = np.array([[0.5, -0.5], [0.5, -0.5], [1.0, 1.0], [0.0, 0.0]], np.float32)
    residual = np.array([[0.125, 0.125], [0.5, -0.5], [-1.0, -0.5], [1.0, -1.0]], np.float32)
    talking = np.array([False, False, False, True])
    expected = [[0.75, -0.25], [1.0, -1.0], [-1.0, 0.0], [0.0, 0.0]]
    assert_array_equal(corrected(own, residual, talking), expected)


@pytest.mark.parametrize("learn", list(RESIDUAL_CUTS))
def test_a_residual_moves_the_robots(learn):
    envs = [parallel_env(learn=learn, residual=residual) for residual in (False, True)]
    for env in envs:
        env.reset(seed=3)
        for _ in range(20):
            env.step({agent: np.full(env.action_space(agent).shape, 0.25, np.float32)
                      for agent in env.agents})  # fmt: skip
    given, added = (env.world.state.pose for env in envs)
    assert (given != added).any(axis=1).all()


def scrambled(feedback, keep, rng):
    """The same feedback for one robot, and nonsense for all others."""
    others = np.arange(len(feedback.reward)) != keep

    def mix(array, values):
        mixed = array.copy()
        mixed[others] = values.astype(array.dtype)[others]
        return mixed

    readings, heard = feedback.readings, feedback.heard
    readings = type(readings)(
        proximity=mix(readings.proximity, rng.uniform(0, 1, readings.proximity.shape)),
        ground=mix(readings.ground, rng.uniform(0, 1.3, readings.ground.shape)),
        odometry=mix(readings.odometry, rng.uniform(-0.01, 0.01, readings.odometry.shape)),
    )
    heard = type(heard)(
        valid=mix(heard.valid, rng.random(heard.valid.shape) < 0.5),
        sender=mix(heard.sender, rng.integers(0, len(others), heard.sender.shape)),
        words=mix(heard.words, rng.uniform(0, 1, heard.words.shape)),
        beam=mix(heard.beam, rng.uniform(-0.1, 0.1, heard.beam.shape)),
        frames=mix(heard.frames, rng.integers(1, 10, heard.frames.shape)),
    )
    return replace(feedback, readings=readings, heard=heard)


@pytest.mark.parametrize("keep", [0, 4])
def test_a_robot_is_shown_and_does_only_what_follows_from_its_own_readings_and_messages(keep, busy):
    scenario, rng = busy, np.random.default_rng(0)
    recipe = Recipe("r", SocialOdometryParameters(double=True), SGIKF(), SubsumptionParameters())
    loop = ControlLoop(scenario, recipe, [SEED])
    other = recipe.build(scenario, [SEED])
    other.observe(scrambled(loop.world.feedback, keep, rng))
    cut = CUTS["both"](scenario, recipe, [SEED], "rigid")
    layout = ObservationLayout(cut.fields(Bounds(scenario, scenario.n_ticks)))
    sheet = Sheet(layout, loop.world.rows)

    def shown(controller):
        estimator = controller.estimator
        parts = {"encounter": estimator.encounter, "situation": estimator.situation}
        return sheet.write(parts)[keep]

    exchanges = 0
    for _ in range(1500):
        assert_array_equal(shown(other), shown(loop.controller))
        exchanges += loop.controller.estimator.encounter.valid[keep]
        mine, theirs = loop.controller.command(), other.command()
        for field in fields(mine):
            ours, his = getattr(mine, field.name)[keep], getattr(theirs, field.name)[keep]
            assert_array_equal(ours, his, field.name)
        feedback = loop.world.tick(mine)
        loop.controller.observe(feedback)
        other.observe(scrambled(feedback, keep, rng))
    assert exchanges > 5


@pytest.mark.parametrize(
    ("learn", "residual", "period"),
    [*product(CUTS, [False], [2, 5]), *product(RESIDUAL_CUTS, [True], [2, 5])],
)
def test_a_held_action_is_the_same_action_given_at_every_tick(learn, residual, period, sampler):
    held = parallel_env(learn=learn, residual=residual, decision_period=period)
    fine = parallel_env(learn=learn, residual=residual)
    held.reset(seed=3)
    fine.reset(seed=3)
    act = sampler(held, 5)
    for _ in range(40):
        actions = act()
        slow = held.step(actions)
        rewards = dict.fromkeys(fine.agents, 0.0)
        for _ in range(period):
            fast = fine.step(actions)
            rewards = {agent: rewards[agent] + fast[1][agent] for agent in rewards}
        for agent, observation in slow[0].items():
            assert_array_equal(observation, fast[0][agent])
        assert slow[1] == rewards
        assert slow[4] == fast[4]


def test_a_learner_of_everything_hears_what_was_said(constant):
    env = parallel_env(learn="everything", **{"radio.loss_near": 0.0, "radio.loss_far": 0.0})
    env.reset(seed=0)
    words = np.linspace(-1, 1, WORDS, dtype=np.float32)
    loud, quiet = constant(env, 0, 0, 1, *words), constant(env, 0, 0, -1, *words)
    names = env.observation_layout.names
    valid, told = names.index("heard.valid.0"), names.index("heard.words.0.0")
    said, *_ = env.step(loud)
    hears = [o for o in said.values() if o[valid] == 1.0]
    assert hears
    for observation in hears:
        assert_array_equal(observation[told : told + WORDS], words)
    silent, *_ = env.step(quiet)
    assert not any(o[valid] for o in silent.values())
    assert env.world.state.lost_events.sum() == 0
