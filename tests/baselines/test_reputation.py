"""A robot remembers who told what, and judges it by what it finds."""

import numpy as np
import pytest

from baselines.estimators.reputation_odometry import (
    ReputationMind,
    ReputationOdometryParameters,
    describe_reputations,
    judge_all,
    merge,
    needs_weight,
    remember,
    trust,
)
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import one_record
from swarm_forage_env.scenarios import find_scenario

trust, remember, describe_reputations = map(entry_point, (trust, remember, describe_reputations))
judge_all = entry_point(judge_all)
needs_weight, merge = map(entry_point, (needs_weight, merge))

SCENARIO = find_scenario("es1")
NUMBERS = one_record(ReputationOdometryParameters(weighs_unknown=True).layer(SCENARIO).numbers)[0]


class Robot:
    """A robot of five, and what the others tell it."""

    def __init__(self):
        minds = ReputationMind.array((1,), robots=5)
        self.mind = minds[0]
        self.belief, self.reputation = minds["belief"][0], minds["reputation"][0]
        self.exchange = minds["exchange"][0]

    def hear(self, teller, place, area=NEST, p=0.0):
        self.belief["last_partner"] = teller
        self.belief["heard_weight"][:] = 0.0
        self.belief["heard_weight"][area] = 4.0
        self.belief["heard_sum"][area] = 4.0 * np.array(place)
        self.belief["heard_p"][area] = p
        describe_reputations(self.mind, NUMBERS)
        remember(self.mind, area, NUMBERS)
        return self

    def find(self, place, area=NEST):
        self.belief["location"][area] = place
        judge_all(self.reputation, self.belief, area, True, NUMBERS)
        return self

    def counts(self, other):
        return float(self.reputation["right"][other]), float(self.reputation["wrong"][other])


@pytest.fixture
def robot():
    return Robot()


def test_trust_is_the_mean_of_a_beta_distribution(robot):
    robot.reputation["right"][:3], robot.reputation["wrong"][:3] = (0, 3, 1), (0, 0, 4)
    assert [trust(robot.reputation, k) for k in range(3)] == pytest.approx([1 / 2, 4 / 5, 2 / 7])


def test_what_was_told_is_judged_once_when_the_area_is_found(robot):
    robot.hear(1, (1.0, 0.0)).hear(2, (0.0, 1.0))
    assert robot.counts(1) == robot.counts(2) == (0.0, 0.0)
    robot.find((1.1, 0.0)).find((1.1, 0.0))
    assert (robot.counts(1), robot.counts(2)) == ((1.0, 0.0), (0.0, 1.0))
    assert robot.counts(3) == (0.0, 0.0)


def test_who_told_the_place_where_a_robot_gets_lost_was_wrong(robot):
    robot.hear(1, (0.1, 0.0)).hear(2, (3.0, 0.0)).hear(3, (0.0, 0.0), area=PREY)
    judge_all(robot.reputation, robot.belief, NEST, False, NUMBERS)
    assert [robot.counts(k) for k in (1, 2, 3)] == [(0.0, 1.0), (0.0, 0.0), (0.0, 0.0)]


def test_the_exchange_shows_the_past_of_the_teller_and_of_who_told_the_same(robot):
    robot.reputation["right"][:4], robot.reputation["wrong"][:4] = (2, 0, 8, 0), (1, 0, 0, 8)
    robot.hear(2, (1.0, 0.0)).hear(3, (1.0, 0.2)).hear(1, (-1.0, 0.0)).hear(0, (1.0, 0.1))
    exchange = robot.exchange
    assert (exchange["right"], exchange["wrong"]) == (2.0, 1.0)
    assert exchange["support"].tolist() == pytest.approx([0.9 + 0.1, 0.0])
    assert exchange["suspicion"].tolist() == pytest.approx([0.1 + 0.9, 0.0])
    assert exchange["dissent"].tolist() == pytest.approx([0.5, 0.0])
    robot.hear(0, (1.0, 0.1))
    assert robot.exchange["support"][NEST] == pytest.approx(1.0), "nobody supports himself"


WIDE = one_record({"slack": 0.25, "drift": 0.125, "sure_within": 4.0, "remembers_within": 12.0})[0]


@pytest.mark.parametrize(("path", "is_found_out"), [(12.0, True), (12.1, False)])
def test_what_is_told_is_remembered_for_a_path_and_not_longer(robot, path, is_found_out):
    robot.hear(1, (0.5, 0.0)).hear(2, (9.0, 0.0))
    robot.reputation["path"] += path
    judge_all(robot.reputation, robot.belief, NEST, False, WIDE)
    assert robot.counts(1) == (0.0, float(is_found_out)), "it told the place of the loss"
    judge_all(robot.reputation, robot.belief, NEST, True, WIDE)
    assert robot.counts(2) == (0.0, float(is_found_out))
    robot.belief["heard_weight"][:], robot.belief["last_partner"] = 4.0, 3
    describe_reputations(robot.mind, WIDE)
    told = 2 / 3 if is_found_out else 0.0  # both tellers are trusted to a third by now
    assert robot.exchange["support"][NEST] + robot.exchange["dissent"][NEST] == pytest.approx(told)
    assert robot.exchange["support"][PREY] + robot.exchange["dissent"][PREY] == 0.0


def test_the_weighting_is_asked_about_unknown_areas_only_if_it_is_to_weigh_them():
    exchange = Exchange.array((1,))
    exchange["heard_known"], exchange["own_known"] = (1, 1), (1, 0)
    witness = one_record(ReputationOdometryParameters().layer(SCENARIO).numbers)[0]
    asked = [[needs_weight(exchange[0], k, own) for k in (0, 1)] for own in (NUMBERS, witness)]
    assert asked == [[True, True], [True, False]]


def test_without_that_it_is_sceptical_odometry_bit_for_bit():
    numbers = {"faults.liar.share": 0.2, "task.duration": 300.0}
    found = []
    for estimator in ("sceptical_odometry", "reputation_odometry"):
        controller = find_controller(f"{estimator}+validation_gate+subsumption:pause=5")
        loop = Loop(find_scenario("es1", numbers), controller, [0, 1], "kinematic")
        for _ in range(3000):
            loop.step()
        found.append(loop.world.robots["pose"].copy())
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize(
    ("visited", "own_p", "heard_p", "off", "counts"),
    [(1, 4.0, 2.0, 0.9, (1.0, 0.0)), (1, 4.0, 2.0, 1.1, (0.0, 1.0)),  # wide by 0.25 + 0.125 * 6
     (1, 4.1, 2.0, 9.0, (0.0, 0.0)), (0, 1.0, 0.0, 2.0, (0.0, 0.0))],
)  # fmt: skip
def test_a_robot_that_was_there_lately_judges_at_once_by_both_paths(
    robot, visited, own_p, heard_p, off, counts
):
    belief = robot.belief
    belief["known"][NEST], belief["visited"][NEST] = True, visited
    belief["p"][NEST], belief["location"][NEST] = own_p, (1.0, 2.0)
    belief["last_partner"], belief["heard_weight"][NEST] = 2, 2.0
    belief["heard_sum"][NEST], belief["heard_p"][NEST] = (2.0, 2.0 * (2.0 + off)), heard_p
    remember(robot.mind, NEST, WIDE)
    assert robot.counts(2) == counts
    assert robot.reputation["place"][2, NEST].tolist() == pytest.approx([1.0, 2.0 + off])
    assert robot.reputation["is_open"][2, NEST] == (counts == (0.0, 0.0))
