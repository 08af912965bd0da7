"""What holds for every registered part: it says where it comes from, and stays decentralised."""

import inspect
import re

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.controller import REGISTRIES
from baselines.estimators import ESTIMATORS
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.rows import RowWeighting
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, MotionLayer, WeightingLayer
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, SCENARIOS, Registry
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from tests.outside import exchanges

PARTS = [(layer, name) for layer, registry in REGISTRIES.items() for name in registry]
SOURCE = r"Source: |\(TR\)|\(ANTS\)|\(BOIDS\)|Not in the papers?:"
LAYER = {"estimator": EstimatorLayer, "weighting": WeightingLayer, "motion": MotionLayer}

FORAGERS = [name for name in CONTROLLERS if CONTROLLERS[name].supports(Scenario())]
BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62}
"""Numbers of es1 under which robots soon find areas and meet."""

ROW = 2


def made_for_foraging(part):
    """Whether a part is for robots that forage; waypoints have contracts of their own."""
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
    assert issubclass(part, Parameters)
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
    with pytest.raises(ValueError, match="two toys are named 'a'; rename one, or restart"):
        registry.register("a")(2)


RULES = [
    name
    for name in WEIGHTING_RULES
    if made_for_foraging(WEIGHTING_RULES[name]) and name != "filter"  # that of its estimator
]
OWN_RULES = [name for name in ESTIMATORS if made_for_foraging(ESTIMATORS[name])]


def random_exchanges(rng, rows):
    """Exchanges about areas that most robots know, of which each has just ended."""
    p = rng.exponential(5.0, (2, rows, 2)).astype(np.float32)
    known = rng.random((2, rows, 2)) < 0.8
    p[~known] = 0.0
    return exchanges(
        rows,
        own_p=p[0],
        heard_p=p[1],
        own_known=known[0],
        heard_known=known[1],
        disagreement=rng.random((rows, 2)),
        own_distance=rng.random((rows, 2)),
        heard_distance=rng.random((rows, 2)),
        range=rng.random(rows),
        n_averaged=rng.integers(0, 60, rows),
        goal=np.eye(3)[rng.integers(0, 3, rows)],
    )


def on_arrays(part):
    """A rule of foraging as a function of arrays, compiled or not."""
    return part if callable(part) else RowWeighting(part.layer(find_scenario("es1")))


def check_shares(rule):
    """Assert that every weight is a share, in single precision."""
    g = rule(random_exchanges(np.random.default_rng(0), 1000))
    assert g.shape == (1000, 2)
    assert g.dtype == np.float32
    assert np.all((g >= 0.0) & (g <= 1.0))
    assert np.count_nonzero(g) > 500  # a gate refuses most of what is drawn at random
    assert 0.0 <= rule.heard_p_share <= 1.0


def check_own_row(rule):
    """Assert that a robot's weights are the same whatever other robots were told."""
    rng = np.random.default_rng(0)
    mine, others = random_exchanges(rng, 5), random_exchanges(rng, 5)
    mine.own_known[ROW] = mine.heard_known[ROW] = True
    others[ROW] = mine[ROW]
    assert_array_equal(rule(mine)[ROW], rule(others)[ROW])


@pytest.mark.parametrize("name", RULES)
def test_every_weight_is_a_share_of_the_own_row(name):
    rule = on_arrays(WEIGHTING_RULES[name]())
    check_shares(rule)
    check_own_row(rule)


@pytest.mark.parametrize("name", OWN_RULES)
def test_the_weight_of_every_filter_is_a_share_of_the_own_row(name):
    rule = RowWeighting(ESTIMATORS[name]().layer(find_scenario("es1")).own_weighting)
    check_shares(rule)
    check_own_row(rule)


@pytest.fixture(scope="module")
def recorded():
    """Under each controller, what a swarm senses, hears and does in a while."""

    def run(name):
        loop = running(name)
        before = [loop.world.robots.copy()]
        for _ in range(1200):
            loop.step()
            before.append(loop.world.robots.copy())
            assert np.abs(before[-1]["command"]["wheels"]).max() <= 1.0
        return before

    kept = {}
    return lambda name: kept.setdefault(name, run(name))


def running(name):
    """One world under a controller that has seen nothing yet."""
    loop = Loop(find_scenario("es1", BUSY), find_controller(name), [3], "kinematic")
    loop.controller.reset(0, 1, [3])
    return loop


def observe(loop, robots):
    """Let the controller take in what was recorded in a tick."""
    loop.world.robots[:] = robots
    loop.run_stages("observe")


def decide(loop):
    """What the controller commands next: wheels, and who broadcasts."""
    loop.controller.call_rules()
    loop.run_stages("decide")
    return loop.world.robots["command"][0]


@pytest.mark.parametrize("name", FORAGERS)
def test_a_robot_acts_only_on_what_it_senses_and_hears(recorded, name):
    rng, honest, fooled = np.random.default_rng(0), running(name), running(name)
    for robots in recorded(name):
        observe(honest, robots)
        tell_only_what_is_heard(honest, fooled, robots["heard"][0, ROW], rng)
        observe(fooled, mixed_up(robots, rng))
        assert_same_mind(layers_of(honest), layers_of(fooled))
        commands = decide(honest), decide(fooled)
        assert commands[0][ROW] == commands[1][ROW]
    assert not np.array_equal(commands[0]["wheels"], commands[1]["wheels"])


def mixed_up(robots, rng):
    """The same for one robot, and nonsense for all others, in which no range is below zero."""
    found = robots.copy()
    for record in ("readings", "heard"):
        for name in robots[record].dtype.names:
            mine = robots[record][name]
            others = mine[:, rng.permutation(mine.shape[1])]
            if mine.dtype == np.float32:
                others = others * rng.lognormal(0.0, 0.5, mine.shape).astype(np.float32)
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


def layers_of(loop):
    """The layers written by hand, which may run below a policy."""
    return vars(loop.controller).get("_inner", loop.controller)


def assert_same_mind(honest, fooled):
    """Assert that the robot believes the same, and is shown the same exchange if one ended."""
    mine, theirs = honest.minds["estimator"][0, ROW], fooled.minds["estimator"][0, ROW]
    is_stale = not mine["exchange"]["is_valid"]
    skipped = {"message", "is_composed", "is_heard", "exchange" if is_stale else ""}
    for name in set(mine.dtype.names) - skipped:
        assert (mine[name] == theirs[name]).all(), name
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


@pytest.mark.parametrize("name", list(CONTROLLERS))
def test_every_controller_can_be_made_anew_from_its_parameters(name):
    controller = CONTROLLERS[name]
    assert controller.with_parameters(controller.parameters) == controller
