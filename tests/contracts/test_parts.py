"""What holds for every registered part: it says where it comes from, and stays decentralised."""

import inspect
import re
from dataclasses import fields, replace

import baselines.recipes  # noqa: F401 enters the controllers
import numpy as np
import pytest
from swarm_forage_env.waypoints_scenario import WaypointsScenario

from baselines.controller import made_for
from baselines.estimators import ESTIMATORS
from baselines.motion import MOTIONS
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.foraging.scenario import Part, Scenario
from swarm_forage_env.interface import Encounter, Feedback
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, SCENARIOS, Registry
from swarm_forage_env.scenarios import find_scenario

LAYERS = {"weighting": WEIGHTING_RULES, "estimator": ESTIMATORS, "motion": MOTIONS}
PARTS = [(layer, name) for layer, registry in LAYERS.items() for name in registry]
SOURCE = r"Source: |\(TR\)|\(ANTS\)|\(BOIDS\)|Not in the papers?:"

FORAGERS = [name for name in CONTROLLERS if CONTROLLERS[name].runs_on(Scenario())]
RULES = [name for name in WEIGHTING_RULES if Scenario in made_for(WEIGHTING_RULES[name])]
"""Those that are made for foraging; the world of waypoints has contracts of its own."""

BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62}
"""Numbers of es1 under which robots soon find areas and meet."""

ROW = 2


@pytest.mark.parametrize(("layer", "name"), PARTS)
def test_every_part_cites_its_source(layer, name):
    part = LAYERS[layer][name]
    texts = [inspect.getdoc(part) or "", inspect.getmodule(part).__doc__ or ""]
    assert texts[0]
    assert any(re.search(SOURCE, text) for text in texts)


@pytest.mark.parametrize(("layer", "name"), PARTS)
def test_every_part_is_a_frozen_group_of_described_parameters(layer, name):
    part = LAYERS[layer][name]
    assert issubclass(part, Part)
    assert part.model_config["frozen"]
    assert part.model_config["extra"] == "forbid"
    assert all(field.description for field in part.model_fields.values())
    assert part() == part(**part().model_dump())


@pytest.mark.parametrize("name", list(ENGINES))
def test_every_engine_says_what_it_is(name):
    assert inspect.getdoc(ENGINES[name])


@pytest.mark.parametrize("name", list(SCENARIOS))
def test_every_scenario_stands_under_its_own_name(name):
    assert isinstance(SCENARIOS[name], Scenario | WaypointsScenario)
    assert SCENARIOS[name].name == name


def test_two_parts_cannot_have_one_name():
    registry = Registry("toy")
    registry.register("a")(1)
    with pytest.raises(ValueError, match="two toys are named 'a'"):
        registry.register("a")(2)


def random_encounter(rng, rows):
    p = rng.exponential(5.0, (2, rows, 2)).astype(np.float32)
    known = rng.random((2, rows, 2)) < 0.8
    p[~known] = 0.0
    return Encounter(
        valid=rng.random(rows) < 0.5,
        own_p=p[0],
        heard_p=p[1],
        own_known=known[0],
        heard_known=known[1],
        disagreement=rng.random((rows, 2)).astype(np.float32),
        own_distance=rng.random((rows, 2)).astype(np.float32),
        heard_distance=rng.random((rows, 2)).astype(np.float32),
        range=rng.random(rows).astype(np.float32),
        frames=rng.integers(0, 60, rows).astype(np.float32),
        goal=rng.integers(-1, 2, rows).astype(np.int8),
    )


@pytest.mark.parametrize("name", RULES)
def test_every_weight_is_a_share_of_single_precision(name):
    rule = WEIGHTING_RULES[name]()
    g = rule(random_encounter(np.random.default_rng(0), 1000))
    assert g.shape == (1000, 2)
    assert g.dtype == np.float32
    assert np.all((g >= 0.0) & (g <= 1.0))
    assert 0.0 <= rule.heard_p_share <= 1.0


@pytest.mark.parametrize("name", RULES)
def test_every_weight_depends_on_the_own_row_only(name):
    rule, rng = WEIGHTING_RULES[name](), np.random.default_rng(0)
    mine, others = random_encounter(rng, 5), random_encounter(rng, 5)
    for field in fields(Encounter):
        getattr(others, field.name)[ROW] = getattr(mine, field.name)[ROW]
    np.testing.assert_array_equal(rule(mine)[ROW], rule(others)[ROW])


@pytest.fixture(scope="module")
def recorded():
    """Under each recipe, what a swarm senses and hears in a while, and what it does."""

    def run(name):
        scenario = find_scenario("es1", BUSY)
        loop = ControlLoop(scenario, find_controller(name), [3], "kinematic")
        told = [loop.world.feedback]
        told.extend(loop.step() for _ in range(1200))
        return scenario, told

    kept = {}
    return lambda name: kept.setdefault(name, run(name))


@pytest.mark.parametrize("name", FORAGERS)
def test_a_robot_acts_only_on_what_it_senses_and_hears(recorded, name):
    scenario, told = recorded(name)
    recipe, rng = find_controller(name), np.random.default_rng(0)
    honest, fooled = recipe.build(scenario, [3]), recipe.build(scenario, [3])
    for feedback in told:
        commands = honest.act(feedback), fooled.act(mixed_up(feedback, rng))
        for field in fields(commands[0]):
            first, second = (getattr(command, field.name)[ROW] for command in commands)
            np.testing.assert_array_equal(first, second, err_msg=field.name)
    assert not np.array_equal(commands[0].wheels, commands[1].wheels)


def mixed_up(feedback, rng):
    """The same for one row, and nonsense for all others."""
    return Feedback(
        readings=replaced(feedback.readings, rng),
        heard=replaced(feedback.heard, rng),
        reward=feedback.reward,
        done=feedback.done,
    )


def replaced(readings, rng):
    changed = {}
    for field in fields(readings):
        mine = getattr(readings, field.name)
        others = mine[rng.permutation(len(mine))]
        if mine.dtype == np.float32:
            others = others + rng.normal(0.0, 0.1, mine.shape).astype(np.float32)
        others[ROW] = mine[ROW]
        changed[field.name] = others
    return replace(readings, **changed)


@pytest.mark.parametrize("name", FORAGERS)
def test_what_a_robot_hears_does_matter_to_it(recorded, name):
    """The other side of the contract: the recording holds messages that change a command."""
    scenario, told = recorded(name)
    recipe = find_controller(name)
    hearing, deafened = recipe.build(scenario, [3]), recipe.build(scenario, [3])
    same = True
    for feedback in told:
        heard = replace(feedback.heard, valid=np.zeros_like(feedback.heard.valid))
        first, second = hearing.act(feedback), deafened.act(replace(feedback, heard=heard))
        same = same and np.array_equal(first.wheels, second.wheels)
    assert same == (not any(feedback.heard.valid.any() for feedback in told))


@pytest.mark.parametrize("physics", list(ENGINES))
@pytest.mark.parametrize("name", FORAGERS)
def test_every_recipe_runs_without_nonsense(name, physics):
    scenario = find_scenario("es1", BUSY)
    loop = ControlLoop(scenario, find_controller(name), [0, 1], physics)
    for _ in range(200):
        feedback = loop.step()
        situation = loop.controller.estimator.situation
        for held in (feedback.readings, feedback.heard, situation):
            for field in fields(held):
                assert np.isfinite(getattr(held, field.name)).all(), field.name
        assert np.abs(situation.wheels).max() <= 1.0
    assert np.isfinite(loop.world.state.pose).all()


@pytest.mark.parametrize("name", list(CONTROLLERS))
def test_every_recipe_can_be_made_anew_from_its_parameters(name):
    recipe = CONTROLLERS[name]
    assert recipe.with_parameters(recipe.parameters) == recipe
