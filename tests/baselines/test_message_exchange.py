"""Social odometry: what robots tell each other, where they find areas, and how they get lost."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from baselines.estimators.area_memory import NEST_BELOW, PREY_BELOW, area_under
from baselines.estimators.belief import NOWHERE
from baselines.estimators.message_exchange import heard_location
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.equations.geometry import range_and_bearing, to_body

PLACES, ANGLES = st.floats(-3.0, 3.0), st.floats(-math.pi, math.pi)
POSES = st.tuples(PLACES, PLACES, ANGLES)


@given(POSES, POSES, st.tuples(PLACES, PLACES))
def test_an_area_told_over_an_exact_beam_is_where_it_is(receiver, sender, area):
    x_i, y_i, theta_i = receiver
    x_j, y_j, theta_j = sender
    D, gamma_i = range_and_bearing(x_j - x_i, y_j - y_i, theta_i)  # noqa: N806 as in the paper
    _, gamma_j = range_and_bearing(x_i - x_j, y_i - y_j, theta_j)
    d_j, phi_j = range_and_bearing(area[0] - x_j, area[1] - y_j, theta_j)
    expected = to_body(area[0] - x_i, area[1] - y_i, math.cos(theta_i), math.sin(theta_i))
    if D > 1e-6:  # two robots in one place see no direction
        assert heard_location(D, gamma_i, gamma_j, d_j, phi_j) == pytest.approx(expected, abs=1e-9)


def test_what_was_unknown_is_copied_with_its_confidence(pair):
    # TR, Eq. 14
    two, nest = pair("dsgiff"), np.array([-0.6, 0.1])
    two.know(1, NEST, *nest, p=1.7, came_from=True)
    two.talk()
    place, p = two.believed(0, NEST)
    np.testing.assert_allclose(place, nest, atol=1e-6)
    assert p == pytest.approx(1.7)
    assert two.beliefs.known.astype(bool).tolist() == [[True, False], [True, False]]
    assert two.beliefs.goal[0] == NEST


def crossing(pair, controller):
    """Two robots that know both areas, on their ways to prey (0) and nest (1), and disagree."""
    two = pair(controller)
    two.know(0, NEST, -0.6, 0.1, p=1.0, came_from=True)
    two.know(0, PREY, 0.5, -0.2, p=3.0)
    two.know(1, NEST, -0.5, 0.3, p=2.0)
    two.know(1, PREY, 0.6, 0.0, p=0.5, came_from=True)
    return two


def blended(own, heard, g):
    return (1.0 - g) * np.array(own) + g * np.array(heard)


def fermi(own, heard):
    return 1.0 / (1.0 + math.exp(-0.01 * 100.0 * (own - heard)))


def kalman(own, heard):
    return own / (own + heard)


@pytest.mark.parametrize(
    ("controller", "weighs", "share", "is_double"),
    [("ssgikf", kalman, 0.0, False), ("ssgiff", fermi, 1.0, False), ("dsgikf", kalman, 0.0, True),
     ("dsgiff", fermi, 1.0, True)],
)  # fmt: skip
def test_a_double_filter_corrects_both_areas_and_a_single_one_the_goal(
    pair, controller, weighs, share, is_double
):
    two = crossing(pair, controller)
    two.talk()
    for area, robot, own, heard, p_own, p_heard in (
        (NEST, 0, [-0.6, 0.1], [-0.5, 0.3], 1.0, 2.0),
        (NEST, 1, [-0.5, 0.3], [-0.6, 0.1], 2.0, 1.0),
        (PREY, 0, [0.5, -0.2], [0.6, 0.0], 3.0, 0.5),
        (PREY, 1, [0.6, 0.0], [0.5, -0.2], 0.5, 3.0),
    ):
        is_corrected = is_double or robot == {NEST: 1, PREY: 0}[area]
        g = weighs(p_own, p_heard) if is_corrected else 0.0
        place, p = two.believed(robot, area)
        np.testing.assert_allclose(place, blended(own, heard, g), atol=1e-6)
        assert p == pytest.approx((1.0 - g) * p_own + share * g * p_heard, rel=1e-5)


BEAM = (0.1, 0.0, 0.0)


def test_on_its_way_a_single_filter_tells_only_where_it_comes_from(believers):
    for double, told in ((False, [1, 0]), (True, [1, 1])):
        swarm = believers(1, double=double)
        swarm.know(0, NEST, 0.0, -2.0, p=1.5, came_from=True)
        swarm.know(0, PREY, 3.0, 0.0, p=4.0)
        swarm.sense()
        (sent,), speaking = swarm.say()
        assert speaking[0]
        assert sent.has_estimate.tolist() == told
        for area, about in ((NEST, [2.0, -math.pi / 2, 1.5]), (PREY, [3.0, 0.0, 4.0])):
            if told[area]:
                numbers = sent.distance[area], sent.direction[area], sent.p[area]
                np.testing.assert_allclose(numbers, about, rtol=1e-6)


@pytest.mark.parametrize(("first_hand", "areas"), [(True, [0, 1]), (False, [1, 1])])
def test_hearsay_is_passed_on_only_without_first_hand(believers, first_hand, areas):
    swarm = believers(1, double=True, first_hand=first_hand)
    swarm.know(0, NEST, 0.0, -2.0, p=1.5, visited=False)
    swarm.sense()
    assert swarm.say()[1][0] != first_hand
    swarm.know(0, PREY, 3.0, 0.0, p=4.0, came_from=True)
    swarm.sense()
    sent, _ = swarm.say()
    assert sent.has_estimate[0].tolist() == areas


def test_who_knows_both_areas_tells_of_none_of_which_it_is_too_unsure(believers):
    swarm = believers(1, double=True, tells_within=4.0)
    swarm.know(0, NEST, 0.0, -2.0, p=4.0, came_from=True)
    swarm.know(0, PREY, 3.0, 0.0, p=4.1)
    swarm.sense()
    sent, speaking = swarm.say()
    assert (speaking[0], sent.has_estimate[0].tolist()) == (True, [1, 0])
    swarm.beliefs.p[:] = 5.0
    sent, speaking = swarm.say()
    assert (speaking[0], sent.has_estimate[0].tolist()) == (False, [0, 0])
    swarm.beliefs.known[0, PREY] = False
    sent, speaking = swarm.say()
    assert (speaking[0], sent.has_estimate[0].tolist()) == (True, [1, 0]), "however unsure"


@pytest.mark.parametrize(
    ("own_p", "area", "stops"), [(2.9, "nest", False), (3.0, "nest", True), (1.0, "prey", True)]
)
def test_who_is_sure_does_not_stop_for_what_it_knows(believers, message, own_p, area, stops):
    swarm = believers(2, double=True, listens_above=3.0)
    swarm.know(0, NEST, -1.0, 0.0, p=own_p, came_from=True)
    swarm.sense(messages=[(0, 1, message(**{area: (0.7, 0.3, 1.2)}), BEAM)])
    assert swarm.talking[0] == stops


def test_of_many_partners_the_one_whose_time_runs_out_first_is_forgotten_first(believers, message):
    swarm = believers(11, pause=0.0, refractory=100.0, double=True)
    told = message(nest=(0.7, 0.3, 1.2))
    for partner in range(1, 11):
        while not swarm.sense(messages=[(0, partner, told, BEAM)])[0]:
            pass
    assert sorted(swarm.beliefs.recent_partners[0].tolist()) == [*range(3, 11)]


@pytest.mark.parametrize(
    ("ground", "area"),
    [
        ((1.0, 1.0, 1.0), NOWHERE),
        ((0.7, 0.7, 1.3), NOWHERE),  # the darkest that the floor is read
        ((0.65, 0.35, 0.5), PREY),  # the brightest and darkest that the prey area is read
        ((0.0, 0.0, 0.0), NEST),
        ((0.0, 0.0, 1.0), NEST),
        ((0.0, 1.0, 1.0), NOWHERE),
        ((0.5, 1.0, 0.5), PREY),
        ((NEST_BELOW, NEST_BELOW, 0.0), PREY),  # a limit belongs to what is brighter
        ((PREY_BELOW, PREY_BELOW, 0.0), NOWHERE),
    ],
)
def test_two_of_three_ground_sensors_decide(ground, area):
    assert area_under(np.array(ground, np.float32)) == area


def walk_until_lost(robot, step=0.01, ticks=500):
    """Straight on over white floor; how far the robot was when it reported itself lost."""
    for tick in range(1, ticks):
        robot.sense(distance=step)
        if robot.lost[0]:
            return tick * step
    return math.inf


def test_who_looked_in_vain_is_lost_forgets_both_areas_and_hears_nothing(believers, message):
    # TR 5.1
    robot = believers(2, lost_within=0.05, overshoot=0.2, deaf_when_lost=1.0)
    robot.know(0, PREY, 1.0, 0.0, p=1.0, visited=False)
    robot.sense(ground="nest")
    assert robot.beliefs.visited[0].tolist() == [1, 0]
    assert walk_until_lost(robot) == pytest.approx(1.0 - 0.05 + 0.2, abs=0.03)
    assert not robot.beliefs.known[0].any()
    assert not robot.beliefs.visited[0].any()
    assert robot.beliefs.goal[0] == NOWHERE
    told = [(0, 1, message(nest=(0.7, 0.3, 1.2)), (0.1, 0.0, 0.0))]
    talking = []
    for _ in range(11):
        robot.sense(messages=told)
        talking.append(robot.talking[0])
    assert talking == [False] * 9 + [True] * 2
    assert not any(robot.lost)
