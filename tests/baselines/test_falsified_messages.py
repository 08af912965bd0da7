"""What liars and stale robots tell, on cases worked by hand."""

import math

import numpy as np
import pytest

from baselines.estimators.belief import SocialMind
from baselines.estimators.covariance import EllipseMind, falsify_ellipse, repeat_ellipse
from baselines.estimators.falsified_messages import falsify, repeat
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.fault_record import Lie
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

FUNCTIONS = {
    each.__name__: entry_point(each) for each in (falsify, falsify_ellipse, repeat, repeat_ellipse)
}


def mind(kind=SocialMind, pose=(0.0, 0.0, 0.0), told=(1, 0), distance=2.0, direction=0.5, p=3.0):
    """A robot that tells of the nest."""
    found = kind.array((1,))
    found["belief"]["pose"], found["message"]["has_estimate"] = pose, told
    found["message"]["distance"][:, 0], found["message"]["direction"][:, 0] = distance, direction
    found["message"]["p"][:, 0] = p
    return found


def lie(**changes):
    found = Lie.array((1,))
    for name, value in changes.items():
        found[name] = value
    return found


def told(found):
    """Distance, direction and p that are told of the nest."""
    message = found["message"][0]
    return [float(message[name][0]) for name in ("distance", "direction", "p")]


@pytest.mark.parametrize(
    ("falsehood", "expected"),
    [
        ({"turn": math.pi / 2}, (2.0, 0.5 + math.pi / 2, 0.0)),
        ({"turn": -0.5, "p": 1.5}, (2.0, 0.0, 1.5)),
        ({"turn": -0.5, "place": ((1.0, 0.0), (0.0, 0.0))}, (3.0, 0.0, 0.0)),
        ({"turn": -0.5, "place": ((-2.0, 1.0), (0.0, 0.0))}, (1.0, math.pi / 2, 0.0)),
        ({"is_place": True, "place": ((0.0, -4.0), (0.0, 0.0))}, (4.0, -math.pi / 2, 0.0)),
        ({"turn": 0.1, "has_own_p": True, "p": 9.0}, (2.0, 0.6, 3.0)),
    ],
)
def test_a_lie_turns_shifts_or_replaces_the_place(falsehood, expected):
    found = mind()
    FUNCTIONS["falsify"](found[0], lie(**falsehood)[0])
    assert told(found) == pytest.approx(expected, abs=1e-6)
    assert found["message"]["has_estimate"].tolist() == [[1, 0]]
    assert not found["message"]["distance"][0, 1]


def test_the_ellipse_of_a_lie_is_a_circle_of_the_p_told():
    found = mind(EllipseMind)
    found["message"]["short_axis"] = 0.2
    FUNCTIONS["falsify_ellipse"](found[0], lie(p=0.7)[0])
    assert found["message"]["short_axis"][0].tolist() == pytest.approx([0.7, 0.2])
    assert told(found)[2] == pytest.approx(0.7)


@pytest.mark.parametrize("kind", [SocialMind, EllipseMind])
def test_a_stale_robot_goes_on_telling_the_first_place_in_its_own_frame(kind):
    repeat = FUNCTIONS["repeat" if kind is SocialMind else "repeat_ellipse"]
    found = mind(kind, told=(0, 0), distance=2.0, direction=0.0)
    repeat(found[0])
    assert not found["has_stale_message"][0], "it has nothing to tell yet"
    found["message"]["has_estimate"] = (1, 0)
    repeat(found[0])
    assert told(found) == pytest.approx([2.0, 0.0, 3.0])
    found["belief"]["pose"] = (2.0, -1.0, math.pi / 2)  # now the place lies straight ahead
    found["message"]["has_estimate"] = (0, 1)
    found["message"]["distance"], found["message"]["p"] = 9.0, 8.0
    repeat(found[0])
    assert found["message"]["has_estimate"].tolist() == [[1, 0]]
    assert told(found) == pytest.approx([1.0, 0.0, 3.0], abs=1e-6)


def test_a_repeated_ellipse_turns_with_the_robot():
    found = mind(EllipseMind)
    found["message"]["long_direction"], found["message"]["short_axis"] = 0.3, 0.1
    FUNCTIONS["repeat_ellipse"](found[0])
    found["belief"]["pose"][:, 2], found["message"]["short_axis"] = 0.2, 0.5
    FUNCTIONS["repeat_ellipse"](found[0])
    assert found["message"]["long_direction"][0, 0] == pytest.approx(0.1)
    assert found["message"]["short_axis"][0, 0] == pytest.approx(0.1)


def places_sent(loop):
    """Where in the arena the messages of this tick place the nest, by sender, and their p."""
    state, minds = loop.world.robots[0], loop.controller.minds["estimator"][0]
    found = {}
    for i in range(len(state)):
        for sender in state["heard"]["sender"][i, : state["heard"]["n"][i]]:
            message, (x, y, theta) = minds["message"][sender], state["pose"][sender]
            if message["has_estimate"][0]:
                angle = theta + message["direction"][0]
                place = np.array([np.cos(angle), np.sin(angle)]) * message["distance"][0]
                found[int(sender)] = (place + np.array([x, y]), float(message["p"][0]))
    return found


@pytest.mark.parametrize("controller", ["ssgikf", "dsgiff", "sikf", "covariance"])
def test_conspirators_tell_one_place_in_the_arena(controller):
    busy = {"robot.cruise_speed": 0.12, "task.area_distance": 0.62, "radio.max_range": 0.6}
    liars = {"faults.liar.share": 1.0, "faults.liar.conspire": "place"}
    scenario = find_scenario("es1", busy | liars)
    loop = Loop(scenario, find_controller(controller), [2], "kinematic")
    sent = []
    for _ in range(400):
        loop.step()
        sent += places_sent(loop).values()
    places = np.array([place for place, _ in sent])
    fresh = [place for place in places if np.hypot(*(place - places[0])) < 1e-5]
    assert len(fresh) > 20
    assert np.hypot(*(places[0] - scenario.areas[0])) >= 0.31
    assert min(p for _, p in sent) == 0.0


@pytest.mark.parametrize("controller", ["nc", "ssgiff", "dsgikf", "covariance"])
def test_liars_believe_what_they_believed(controller):
    """Of robots that nobody hears, a lie changes nothing."""
    ends = []
    for share in (0.0, 1.0):
        numbers = {"faults.liar.share": share, "faults.mute.share": 1.0}
        loop = Loop(find_scenario("es1", numbers), find_controller(controller), [2], "kinematic")
        for _ in range(100):
            loop.step()
        ends.append(loop.controller.minds["estimator"]["belief"]["location"].copy())
    np.testing.assert_array_equal(*ends)
