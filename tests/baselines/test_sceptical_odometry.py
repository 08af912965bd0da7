"""A sceptical robot takes over the place of an unknown area once two robots told it."""

import numpy as np
import pytest

from baselines.estimators.belief import NOBODY
from baselines.estimators.sceptical_odometry import ScepticalMind, merge
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.record import one_record

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
    assert not robot(3, (1.0, 0.0))["known"].any()
    belief = robot(4, (1.0, 0.29), p=5.0)
    assert belief["known"].tolist() == [1, 0]
    assert belief["location"][NEST].tolist() == pytest.approx([1.0, 0.29])
    assert belief["p"][NEST] == 5.0
    assert belief["pending_sender"][NEST] == NOBODY


@pytest.mark.parametrize(("teller", "place"), [(4, (1.0, 0.31)), (3, (1.0, 0.0))])
def test_nobody_who_disagrees_or_told_it_himself_is_a_witness(robot, teller, place):
    robot(3, (1.0, 0.0))
    assert not robot(teller, place)["known"].any()
    assert robot(5, place)["known"][NEST], "what was told last is what is to be confirmed"


def test_of_a_known_area_the_weighting_decides(robot):
    robot(3, (1.0, 0.0))
    robot(4, (1.0, 0.0), p=5.0)
    belief = robot(5, (3.0, 0.0), weight=0.25)
    assert belief["location"][NEST].tolist() == pytest.approx([1.0, 0.0])  # no goal yet, single
    belief["goal"] = NEST
    belief = robot(5, (3.0, 0.0), weight=0.25)
    assert belief["location"][NEST].tolist() == pytest.approx([1.5, 0.0])
    assert not belief["known"][PREY]
