"""What holds for every registered part: it says where it comes from, and stays decentralised."""

import inspect
import re
from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.controller import REGISTRIES
from baselines.estimators import ESTIMATORS
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.foraging.views import WeightingInput
from swarm_forage_env.interface import EstimatorLayer, MotionLayer, WeightingLayer
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import Part
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, SCENARIOS, Registry
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of

PARTS = [(layer, name) for layer, registry in REGISTRIES.items() for name in registry]
SOURCE = r"Source: |\(TR\)|\(ANTS\)|\(BOIDS\)|Not in the papers?:"
LAYER = {"estimator": EstimatorLayer, "weighting": WeightingLayer, "motion": MotionLayer}

FORAGERS = [name for name in CONTROLLERS if CONTROLLERS[name].supports(Scenario())]
BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62}
"""Numbers of es1 under which robots soon find areas and meet."""

ROW = 2


def made_for_foraging(part):
    """Whether a part may be a layer of foragers; waypoints have contracts of their own."""
    return "foraging" in getattr(part, "tasks", ("foraging",))


@pytest.mark.parametrize(("layer", "name"), PARTS)
def test_every_part_cites_its_source(layer, name):
    part = REGISTRIES[layer][name]
    texts = [inspect.getdoc(part) or "", inspect.getmodule(part).__doc__ or ""]
    assert texts[0]
    assert any(re.search(SOURCE, text) for text in texts)


@pytest.mark.parametrize(("layer", "name"), PARTS)
def test_every_part_is_a_frozen_group_of_described_parameters(layer, name):
    part = REGISTRIES[layer][name]
    assert issubclass(part, Part)
    assert part.model_config["frozen"]
    assert part.model_config["extra"] == "forbid"
    assert all(field.description for field in part.model_fields.values())
    assert part() == part(**part().model_dump())


@pytest.mark.parametrize(("layer", "name"), PARTS)
def test_every_part_gives_a_layer_in_the_tasks_it_is_made_for_or_is_a_rule_in_numpy(layer, name):
    part = REGISTRIES[layer][name]
    for scenario in (find_scenario("es1"), find_scenario("waypoints-05")):
        if task_of(scenario).name in getattr(part, "tasks", ("foraging",)):
            found = part().layer(scenario) if hasattr(part, "layer") else None
            is_rule = callable(part()) or hasattr(part, "start") or name == "filter"
            assert isinstance(found, LAYER[layer]) or is_rule


@pytest.mark.parametrize("name", list(ENGINES))
def test_every_engine_says_what_it_is(name):
    assert inspect.getdoc(ENGINES[name])


@pytest.mark.parametrize("name", list(SCENARIOS))
def test_every_scenario_stands_under_its_own_name(name):
    assert isinstance(SCENARIOS[name], task_of(SCENARIOS[name]).scenario)
    assert SCENARIOS[name].name == name


def test_two_parts_cannot_have_one_name():
    registry = Registry("toy")
    registry.register("a")(1)
    with pytest.raises(ValueError, match="two toys are named 'a'"):
        registry.register("a")(2)


def weighting_rules():
    """Every rule of foraging as a function of arrays, those of the estimators' own included."""
    scenario, found = find_scenario("es1"), []
    for name in WEIGHTING_RULES:
        part = WEIGHTING_RULES[name]()
        if made_for_foraging(part) and name != "filter":
            rule = part if callable(part) else FORAGING.array_weighting(part.layer(scenario))
            found.append(pytest.param(rule, id=name))
    for name in ESTIMATORS:
        if made_for_foraging(ESTIMATORS[name]):
            own = ESTIMATORS[name]().layer(scenario).own_weighting
            rule = FORAGING.array_weighting(own)
            found.append(pytest.param(rule, id=f"filter-of-{name}"))
    return found


def random_exchanges(rng, rows):
    """Exchanges about areas that most robots know, of which each has just ended."""
    p = rng.exponential(5.0, (2, rows, 2)).astype(np.float32)
    known = rng.random((2, rows, 2)) < 0.8
    p[~known] = 0.0
    return WeightingInput(
        valid=np.ones(rows, np.bool_),
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


@pytest.mark.parametrize("rule", weighting_rules())
def test_every_weight_is_a_share_of_single_precision(rule):
    g = rule(random_exchanges(np.random.default_rng(0), 1000))
    assert g.shape == (1000, 2)
    assert g.dtype == np.float32
    assert np.all((g >= 0.0) & (g <= 1.0))
    assert np.count_nonzero(g) > 1000
    assert 0.0 <= rule.heard_p_share <= 1.0


@pytest.mark.parametrize("rule", weighting_rules())
def test_every_weight_depends_on_the_own_row_only(rule):
    rng = np.random.default_rng(0)
    mine, others = random_exchanges(rng, 5), random_exchanges(rng, 5)
    mine.own_known[ROW] = mine.heard_known[ROW] = True
    for field in fields(WeightingInput):
        getattr(others, field.name)[ROW] = getattr(mine, field.name)[ROW]
    assert_array_equal(rule(mine)[ROW], rule(others)[ROW])


@pytest.fixture(scope="module")
def recorded():
    """Under each controller, what a swarm senses, hears and does in a while."""

    def run(name):
        loop = running(name)
        told = [loop.world.robots.copy()]
        for _ in range(1200):
            loop.step()
            told.append(loop.world.robots.copy())
        return told

    kept = {}
    return lambda name: kept.setdefault(name, run(name))


def running(name):
    """One world under a controller that has seen nothing yet."""
    loop = Loop(find_scenario("es1", BUSY), find_controller(name), [3], "kinematic")
    loop.controller.reset(0, 3)
    return loop


def observe(loop, robots):
    """Let the controller take in what was recorded in a tick."""
    loop.world.robots[:] = robots
    loop.controller.observe(0, 1)


def decide(loop):
    """What the controller commands next: wheels, and who broadcasts."""
    loop.controller.consult()
    loop.controller.decide(0, 1)
    return loop.world.robots["command"][0]


@pytest.mark.parametrize("name", FORAGERS)
def test_a_robot_acts_only_on_what_it_senses_and_hears(recorded, name):
    rng, honest, fooled = np.random.default_rng(0), running(name), running(name)
    for robots in recorded(name):
        observe(honest, robots)
        tell_only_what_is_heard(honest, fooled, robots["heard"][0, ROW], rng)
        observe(fooled, mixed_up(robots, rng))
        assert_same_mind(honest.controller, fooled.controller)
        commands = decide(honest), decide(fooled)
        assert commands[0][ROW] == commands[1][ROW]
    assert not np.array_equal(commands[0]["wheels"], commands[1]["wheels"])


def mixed_up(robots, rng):
    """The same for one robot, and nonsense for all others."""
    found = robots.copy()
    for record in ("readings", "heard"):
        for name in robots[record].dtype.names:
            mine = robots[record][name]
            others = mine[:, rng.permutation(mine.shape[1])]
            if mine.dtype == np.float32:
                others = others + rng.normal(0.0, 0.1, mine.shape).astype(np.float32)
            others[:, ROW] = mine[:, ROW]
            found[record][name] = others
    return found


def tell_only_what_is_heard(honest, fooled, heard, rng):
    """Put right the messages that the robot hears, and nonsense in the place of all others."""
    true, minds = (loop.controller.minds["estimator"][0] for loop in (honest, fooled))
    unheard = np.setdiff1d(np.arange(len(minds)), heard["sender"][: heard["n"]])
    minds["message"] = true["message"]
    minds["is_composed"] = True
    for name in minds["message"].dtype.names:
        column = minds["message"][name]
        column[unheard] = rng.integers(0, 2, column[unheard].shape)


def assert_same_mind(honest, fooled):
    """Assert that the robot believes the same, and is shown the same exchange if one ended."""
    mine, theirs = honest.minds["estimator"][0, ROW], fooled.minds["estimator"][0, ROW]
    for name in mine.dtype.names:
        is_stale = name == "exchange" and not mine[name]["is_valid"]
        if name in ("message", "is_composed") or is_stale:
            continue
        assert mine[name] == theirs[name], name
    assert honest.minds["motion"][0, ROW] == fooled.minds["motion"][0, ROW]
    assert_array_equal(honest.shared[0, ROW], fooled.shared[0, ROW])


@pytest.mark.parametrize("name", FORAGERS)
def test_what_a_robot_hears_does_matter_to_it(recorded, name):
    """The other side of the contract: the recording holds messages that change a command."""
    hearing, deafened, same = running(name), running(name), True
    for robots in recorded(name):
        deaf = robots.copy()
        deaf["heard"]["n"] = 0
        observe(hearing, robots)
        observe(deafened, deaf)
        same = same and np.array_equal(decide(hearing)["wheels"], decide(deafened)["wheels"])
    assert same == (not any(robots["heard"]["n"].any() for robots in recorded(name)))


def columns(records, name):
    """Every plain array in structured arrays, by name."""
    if records.dtype.names is None:
        yield name, records
    else:
        for each in records.dtype.names:
            yield from columns(records[each], f"{name}.{each}")


@pytest.mark.parametrize("physics", list(ENGINES))
@pytest.mark.parametrize("name", FORAGERS)
def test_every_controller_runs_without_nonsense(name, physics):
    loop = Loop(find_scenario("es1", BUSY), find_controller(name), [0, 1], physics)
    robots, minds = loop.world.robots, loop.controller.minds["estimator"]
    for _ in range(200):
        loop.step()
        held = robots["readings"], robots["heard"], robots["command"], minds["situation"]
        for records in held:
            for column, numbers in columns(records, ""):
                assert np.isfinite(numbers).all(), column
        assert np.abs(robots["command"]["wheels"]).max() <= 1.0
    assert np.isfinite(robots["pose"]).all()


@pytest.mark.parametrize("name", list(CONTROLLERS))
def test_every_controller_can_be_made_anew_from_its_parameters(name):
    controller = CONTROLLERS[name]
    assert controller.with_parameters(controller.parameters) == controller
