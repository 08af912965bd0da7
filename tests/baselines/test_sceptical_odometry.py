"""A sceptical robot takes over the place of an unknown area once two robots told it."""

import numpy as np
import pytest

from baselines.estimators.belief import NOBODY
from baselines.estimators.sceptical_odometry import ScepticalMind, merge
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import one_record
from swarm_forage_env.scenarios import find_scenario

merge = entry_point(merge)
NUMBERS = one_record({"agreement": 0.3, "double": 0.0, "goal": 0.0})[0]


@pytest.fixture
def robot():
    """A robot that knows nothing, and how it ends an exchange in which it was told of the nest."""
    mind = ScepticalMind.array((1,))
    belief = mind["belief"]

    def hear(teller, place, p=2.0, weight=0.5):
        belief["last_partner"] = teller
        belief["heard_weight"][:, NEST] = 4.0
        belief["heard_sum"][:, NEST] = 4.0 * np.array(place)
        belief["heard_p"][:, NEST] = p
        mind["exchange"]["weight"] = weight
        merge(mind[0], np.zeros((1, 0)), 0.0, NUMBERS)
        return belief[0]

    return hear


def test_a_second_teller_who_agrees_is_believed(robot):
    belief = robot(3, (1.0, 0.0))
    assert not belief["known"].any()
    assert belief["pending_from"].tolist() == [3, NOBODY]
    assert belief["pending"][NEST].tolist() == [1.0, 0.0]
    belief = robot(4, (1.0, 0.29), p=5.0)
    assert belief["known"].tolist() == [1, 0]
    assert belief["location"][NEST].tolist() == pytest.approx([1.0, 0.29])
    assert belief["p"][NEST] == 5.0
    assert belief["pending_from"][NEST] == NOBODY


@pytest.mark.parametrize(("teller", "place"), [(4, (1.0, 0.31)), (3, (1.0, 0.0))])
def test_nobody_who_disagrees_or_told_it_himself_is_a_witness(robot, teller, place):
    robot(3, (1.0, 0.0))
    belief = robot(teller, place)
    assert not belief["known"].any()
    assert belief["pending"][NEST].tolist() == list(place)
    assert belief["pending_from"][NEST] == teller


def test_what_is_told_last_is_what_is_to_be_confirmed(robot):
    robot(3, (1.0, 0.0))
    robot(4, (-1.0, 0.0))
    assert not robot(5, (1.0, 0.0))["known"].any()
    assert robot(6, (1.0, 0.1))["known"][NEST]


def test_of_a_known_area_the_weighting_decides(robot):
    robot(3, (1.0, 0.0))
    robot(4, (1.0, 0.0), p=5.0)
    belief = robot(5, (3.0, 0.0), weight=0.25)
    assert belief["location"][NEST].tolist() == pytest.approx([1.0, 0.0])  # no goal yet, single
    belief["goal"] = NEST
    belief = robot(5, (3.0, 0.0), weight=0.25)
    assert belief["location"][NEST].tolist() == pytest.approx([1.5, 0.0])
    assert not belief["known"][PREY]


def test_sound_robots_of_the_named_controller_forage_among_liars():
    """Against conspirators the defence brings in more than the filter that it defends."""
    numbers = {"faults.liar.share": 0.2, "faults.liar.conspire": "place", "task.duration": 900.0}
    trips = {}
    for name in ("ssgikf", "ssgikf-sceptical"):
        loop = Loop(find_scenario("es1", numbers), find_controller(name), range(4), "kinematic")
        for _ in range(9000):
            loop.step()
        sound = ~loop.world.faults["kinds"].any(axis=2)
        trips[name] = loop.world.robots["round_trips"][sound].sum()
    assert trips["ssgikf-sceptical"] > 1.2 * trips["ssgikf"]
