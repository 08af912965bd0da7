"""Social odometry: what robots tell each other, and what they make of it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from baselines.estimators.belief import NOBODY
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


@pytest.mark.parametrize("controller", ["ssgikf", "dsgikf", "ssgiff", "dsgiff"])
def test_what_was_unknown_is_copied_with_its_confidence(pair, controller):
    # TR, Eq. 14
    two, nest = pair(controller), np.array([-0.6, 0.1])
    two.know(1, NEST, *nest, p=1.7, came_from=True)
    two.talk()
    place, p = two.believed(0, NEST)
    np.testing.assert_allclose(place, nest, atol=1e-6)
    assert p == pytest.approx(1.7)
    assert two.beliefs.known.astype(bool).tolist() == [[True, False], [True, False]]
    assert two.beliefs.goal[0] == NEST
    place, p = two.believed(1, NEST)
    np.testing.assert_allclose(place, nest, atol=1e-9)
    assert p == 1.7


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


def fermi(difference):
    return 1.0 / (1.0 + math.exp(-0.01 * 100.0 * difference))


@pytest.mark.parametrize(
    ("controller", "g_prey", "p_prey", "g_nest", "p_nest"),
    [
        ("ssgikf", 3.0 / 3.5, 1.5 / 3.5, 2.0 / 3.0, 2.0 / 3.0),
        (
            "ssgiff",
            fermi(2.5), 3.0 - 2.5 * fermi(2.5),
            fermi(1.0), 2.0 - 1.0 * fermi(1.0),
        ),
    ],
)  # fmt: skip
def test_a_single_filter_corrects_the_goal_only(pair, controller, g_prey, p_prey, g_nest, p_nest):
    two = crossing(pair, controller)
    two.talk()
    prey, p = two.believed(0, PREY)
    np.testing.assert_allclose(prey, blended([0.5, -0.2], [0.6, 0.0], g_prey), atol=1e-6)
    assert p == pytest.approx(p_prey, rel=1e-5)
    nest, p = two.believed(1, NEST)
    np.testing.assert_allclose(nest, blended([-0.5, 0.3], [-0.6, 0.1], g_nest), atol=1e-6)
    assert p == pytest.approx(p_nest, rel=1e-5)
    np.testing.assert_allclose(two.believed(0, NEST)[0], [-0.6, 0.1], atol=1e-9)
    np.testing.assert_allclose(two.believed(1, PREY)[0], [0.6, 0.0], atol=1e-9)
    assert two.beliefs.p[0, NEST] == 1.0
    assert two.beliefs.p[1, PREY] == 0.5


@pytest.mark.parametrize("controller", ["dsgikf", "dsgiff"])
def test_a_double_filter_corrects_both_and_both_robots_end_equal(pair, controller):
    two = crossing(pair, controller)
    two.talk()
    share = 0.0 if controller == "dsgikf" else 1.0
    for area, own, heard, p_own, p_heard in (
        (NEST, [-0.6, 0.1], [-0.5, 0.3], 1.0, 2.0),
        (PREY, [0.5, -0.2], [0.6, 0.0], 3.0, 0.5),
    ):
        g = p_own / (p_own + p_heard) if controller == "dsgikf" else fermi(p_own - p_heard)
        for robot in (0, 1):  # TR, Eq. 17
            place, p = two.believed(robot, area)
            np.testing.assert_allclose(place, blended(own, heard, g), atol=1e-6)
            expected = (1.0 - g) * p_own + share * g * p_heard
            assert p == pytest.approx(expected, rel=1e-5)


def test_the_exchange_says_what_the_weighting_needs(pair):
    two = crossing(pair, "dsgikf")
    while not two.loop.exchange.is_valid.any():
        two.loop.step()
    exchange = two.loop.exchange
    assert exchange.is_valid.all()
    np.testing.assert_allclose(exchange.own_p, [[1.0, 3.0], [2.0, 0.5]])
    np.testing.assert_allclose(exchange.heard_p, [[2.0, 0.5], [1.0, 3.0]])
    np.testing.assert_allclose(exchange.disagreement, math.hypot(0.1, 0.2), atol=1e-6)
    hypot = math.hypot
    own_away = [[hypot(0.55, 0.1), hypot(0.55, 0.2)], [hypot(0.55, 0.28), hypot(0.55, 0.02)]]
    heard_away = [[hypot(0.45, 0.3), 0.65], [hypot(0.65, 0.08), hypot(0.45, 0.22)]]
    np.testing.assert_allclose(exchange.own_distance, own_away, atol=1e-6)
    np.testing.assert_allclose(exchange.heard_distance, heard_away, atol=1e-6)
    np.testing.assert_allclose(exchange.range, math.hypot(0.1, 0.02), atol=1e-6)
    assert exchange.goal.argmax(axis=1).tolist() == [PREY, NEST]
    assert exchange.own_known.all()
    assert exchange.heard_known.all()
    frames = two.loop.world.scenario.radio.frames
    assert np.all(exchange.n_averaged == frames * two.TICKS)


BEAM = (0.1, 0.0, 0.0)


def about(said, area):
    """Distance, direction and p of an area in a message."""
    return said.distance[area], said.direction[area], said.p[area]


def test_on_its_way_a_single_filter_tells_only_where_it_comes_from(believers):
    for double, told in ((False, [1, 0]), (True, [1, 1])):
        swarm = believers(1, double=double)
        swarm.know(0, NEST, 0.0, -2.0, p=1.5, came_from=True)
        swarm.know(0, PREY, 3.0, 0.0, p=4.0)
        swarm.sense()
        said, speaking = swarm.say()
        assert speaking[0]
        assert not swarm.lost[0]
        assert said.told[0].tolist() == told
        np.testing.assert_allclose(about(said[0], NEST), [2.0, -math.pi / 2, 1.5], rtol=1e-6)
        if double:
            np.testing.assert_allclose(about(said[0], PREY), [3.0, 0.0, 4.0], rtol=1e-6)


@pytest.mark.parametrize(("first_hand", "told"), [(True, [0, 1]), (False, [1, 1])])
def test_hearsay_is_passed_on_only_without_first_hand(believers, first_hand, told):
    swarm = believers(1, double=True, first_hand=first_hand)
    swarm.know(0, NEST, 0.0, -2.0, p=1.5, visited=False)
    swarm.sense()
    assert swarm.say()[1][0] != first_hand
    swarm.know(0, PREY, 3.0, 0.0, p=4.0, came_from=True)
    swarm.sense()
    said, _ = swarm.say()
    assert said.told[0].tolist() == told


def test_who_knows_both_areas_tells_of_none_of_which_it_is_too_unsure(believers):
    swarm = believers(1, double=True, tells_within=4.0)
    swarm.know(0, NEST, 0.0, -2.0, p=4.0, came_from=True)
    swarm.know(0, PREY, 3.0, 0.0, p=4.1)
    swarm.sense()
    said, speaking = swarm.say()
    assert speaking[0]
    assert said.told[0].tolist() == [1, 0]
    np.testing.assert_allclose(about(said[0], NEST), [2.0, -math.pi / 2, 4.0], rtol=1e-6)
    swarm.beliefs.p[:] = 5.0
    said, speaking = swarm.say()
    assert not speaking[0]
    assert not said.told.any()


def test_who_knows_one_area_tells_of_it_however_unsure(believers):
    swarm = believers(1, double=True, tells_within=4.0)
    swarm.know(0, NEST, 0.0, -2.0, p=400.0, came_from=True)
    swarm.sense()
    said, speaking = swarm.say()
    assert speaking[0]
    assert said.p[0, NEST] == 400.0


@pytest.mark.parametrize(
    ("own_p", "area", "stops"),
    [(2.9, "nest", False), (3.0, "nest", True), (1.0, "prey", True)],
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
    assert sorted(swarm.beliefs.met[0].tolist()) == [*range(3, 11)]


def test_who_gets_lost_breaks_off_the_exchange(believers, message):
    swarm = believers(2, double=True, overshoot=0.0)
    swarm.know(0, NEST, 0.02, 0.0, p=1.0)
    swarm.sense(messages=[(0, 1, message(prey=(0.7, 0.3, 1.2)), BEAM)])
    assert swarm.beliefs.partner[0] == 1
    swarm.sense()  # it is there now, and lost on the next step
    assert swarm.talking[0]
    swarm.sense(distance=0.01)
    assert swarm.lost[0]
    assert swarm.beliefs.partner[0] == NOBODY
    assert not swarm.talking[0]
