"""The experiment of policies in other worlds, on samples worked by hand."""

import pytest

from baselines.papers import transfer
from baselines.papers.figures import WIDEST
from baselines.papers.transfer import AXES, BASE, POLICIES, WORLDS, experiment, table, with_robots
from swarm_forage_env.scenarios import find_scenario

ES1 = find_scenario("es1")


def test_one_world_of_each_axis_of_numbers_is_es1():
    for name in list(AXES)[:4]:
        scenarios = [experiment(BASE, world).configuration(None).scenario
                     for world in AXES[name].values()]  # fmt: skip
        assert scenarios.count(ES1) == 1, name


def test_a_world_may_have_an_engine_and_controllers_numbers_of_their_own():
    for name in (BASE, f"{BASE}:pause=4"):
        both = experiment(name, AXES["engine and payload"]["both"]).configuration("kinematic")
        assert (both.physics, both.controller.estimator.payload) == ("rigid", "int16")
    assert experiment(BASE, WORLDS[0]).configuration("kinematic").physics == "kinematic"


def test_obstacles_stand_on_both_sides():
    scenario = experiment(BASE, AXES["obstacles"]["gates"]).configuration(None).scenario
    ends = {point for each in scenario.obstacles for point in each.points}
    assert ends == {(-x, y) for x, y in ends} == {(x, -y) for x, y in ends}
    assert len(scenario.obstacles) == 4


def test_a_larger_swarm_has_the_density_of_es1():
    grown = experiment(BASE, with_robots(100)).configuration(None).scenario
    area = grown.arena.length * grown.arena.width
    assert area / 100 == pytest.approx(ES1.arena.length * ES1.arena.width / 10, rel=0.01)
    small = experiment(BASE, with_robots(5)).configuration(None).scenario
    assert small.arena == ES1.arena


def test_the_table_tells_where_a_policy_falls_below(episodes):
    trips = {(each, world): [100 + k for k in range(10)] for each in (BASE, *POLICIES)
             for world in WORLDS}  # fmt: skip
    policy, world = POLICIES[1], AXES["robots"]["50"]
    trips[policy, world] = [50 + k for k in range(10)]
    trips[POLICIES[2], world] = [0] * 10
    results = {
        experiment(name, world): episodes(experiment(name, world), counts)
        for (name, world), counts in trips.items()
    }
    lines = table(results, POLICIES).splitlines()
    assert f"| {policy} | 1 of {len(WORLDS)} | robots: 50 (0.52) |" in lines
    assert f"| {POLICIES[0]} | 0 of {len(WORLDS)} | nowhere |" in lines
    figure = transfer.PAPER.figures[0].draw(results, "a command")
    texts = {text.get_text() for axes in figure.axes for text in axes.texts}
    assert {"0.00", "0.52", "1.00"} <= texts
    assert min(axes.images[0].get_array().min() for axes in figure.axes) == -WIDEST
