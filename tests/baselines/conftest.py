"""Fixtures of the controllers' tests: what robots sense and hear, written by hand."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import baselines.controllers  # noqa: F401
import swarm_forage_env.foraging.named
import swarm_forage_env.foraging.task  # noqa: F401 all three enter their parts
from baselines.estimators.belief import Message
from baselines.estimators.message_exchange import compose, has_something_to_say
from baselines.estimators.social_odometry import SocialOdometryParameters
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations.geometry import to_body, to_outer
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.interface import REPLACE
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import one_record, rows
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario

GROUND = {"floor": 1.0, "nest": 0.0, "prey": 0.5}


@pytest.fixture(scope="session")
def numbers_of():
    """The parameters of a layer as a record."""

    def make(numbers):
        return one_record(numbers).view(np.recarray)[0]

    return make


@pytest.fixture(scope="session")
def exchange():
    """Finished exchanges about the nest, one for each given own and heard p [m]."""

    def make(own_p, heard_p):
        own_p, heard_p = np.broadcast_arrays(own_p, heard_p)
        found = Exchange.array((own_p.size,)).view(np.recarray)
        found.is_valid[:] = True
        found.own_p[:, NEST], found.heard_p[:, NEST] = own_p.ravel(), heard_p.ravel()
        found.own_known[:, NEST] = found.heard_known[:, NEST] = True
        found.range[:], found.n_averaged[:], found.goal[:] = 0.1, 10.0, NEST
        return found

    return make


@entry_point
def speak(minds, speaking, numbers):
    """Compose the message of every robot, and note who has something to say."""
    for i in range(minds.shape[0]):
        speaking[i] = has_something_to_say(minds[i], numbers)
        compose(minds[i], numbers)


class Believers:
    """Robots of one world, told tick by tick what they sense and hear."""

    def __init__(self, numbers_of, n_robots, **parameters):
        n = {"n_robots": n_robots, "start_radius": 0.3}
        self.scenario = find_scenario("es1", n | {"exchange_time": 0.5})
        estimator = SocialOdometryParameters(**parameters)
        controller = replace(CONTROLLERS["ssgiff"], estimator=estimator)
        self.loop = Loop(self.scenario, controller, [0], "kinematic")
        self.minds = rows(self.loop.controller.minds["estimator"])
        self.beliefs, self.exchange = self.minds.belief, self.minds.exchange
        self._numbers = numbers_of(estimator.numbers(self.scenario))

    def sense(self, distance=0.0, turn=0.0, ground="floor", messages=()):
        """One tick of the same readings for all; which robots ended an exchange in it.

        Messages are (receiver, sender, message, range and bearings).
        """
        robots = self.loop.world.state
        robots.readings.ground[:] = GROUND[ground]
        robots.readings.odometry[:] = distance, turn
        heard = robots.heard
        heard.n[:] = 0
        for receiver, sender, message, beam in messages:
            slot = heard.n[receiver]
            heard.n[receiver] += 1
            heard.sender[receiver, slot], heard.n_averaged[receiver, slot] = sender, 10
            heard.range_bearing[receiver, slot] = beam
            self.minds.message[sender], self.minds.is_composed[sender] = message, True
        self.loop.run_stages("observe")
        self.minds.is_composed[:] = False
        return self.exchange.is_valid.copy()

    def know(self, robot, area, x, y, p, came_from=False, visited=True):
        """Give a robot an estimate, in its own frame, of an area on which it stood or not."""
        self.beliefs.location[robot, area] = x, y
        self.beliefs.p[robot, area] = p
        self.beliefs.known[robot, area], self.beliefs.visited[robot, area] = True, visited
        if came_from:
            self.beliefs.came_from[robot] = area

    def say(self):
        """The messages that the robots would send now, and which robots would send theirs."""
        speaking = np.zeros(len(self.minds), np.bool_)
        speak(self.minds, speaking, self._numbers)
        return self.minds.message.copy(), speaking

    @property
    def lost(self):
        """Which robots just found themselves lost."""
        return self.loop.world.state.report.is_lost.tolist()

    @property
    def talking(self):
        """Which robots are in an exchange."""
        return self.loop.situation.is_talking.tolist()


@pytest.fixture
def believers(numbers_of):
    """Robots of one world under an estimator with these parameters."""
    return partial(Believers, numbers_of)


def turned(theta):
    """Cosine and sine of a heading, as the frames take it."""
    return math.cos(theta), math.sin(theta)


class Pair:
    """Two robots at rest, 0.1 m apart, with a radio that neither loses nor errs."""

    TICKS = 6
    """An exchange of 0.5 s and the tick in which it ends."""

    def __init__(self, controller, **overrides):
        quiet = {"n_robots": 2, "range_noise": 0.0, "bearing_noise": 0.0, "loss_near": 0.0,
                 "loss_far": 0.0, "exchange_time": 0.5}  # fmt: skip
        scenario = find_scenario("es1", quiet | overrides)
        self.loop = Loop(scenario, CONTROLLERS[controller], [0], "kinematic")
        self.pose, self.action = self.loop.world.state.pose, self.loop.world.state.action
        self.pose[:] = [[-0.05, 0.0, 0.4], [0.05, 0.02, -2.0]]
        self.action.motion[:], self.action.wheels[:] = REPLACE, 0.0
        self.minds = rows(self.loop.controller.minds["estimator"])
        self.beliefs = self.minds.belief
        self.beliefs.pose[:] = [[1.0, -2.0, 2.5], [-0.3, 0.4, -1.0]]  # each in a frame of its own

    def know(self, robot, area, x, y, p, came_from=False):
        """Let a robot believe an area at a place of the world frame."""
        b, pose = self.beliefs, self.pose[robot]
        ahead, left = to_body(x - pose[0], y - pose[1], *turned(pose[2]))
        dx, dy = to_outer(ahead, left, *turned(b.pose[robot, 2]))
        b.location[robot, area] = b.pose[robot, 0] + dx, b.pose[robot, 1] + dy
        b.p[robot, area] = p
        b.known[robot, area] = b.visited[robot, area] = True
        if came_from:
            b.came_from[robot] = area

    def believed(self, robot, area):
        """Where a robot believes an area, in the world frame; and its p."""
        b, pose = self.beliefs, self.pose[robot]
        dx, dy = b.location[robot, area] - b.pose[robot, :2]
        ahead, left = to_body(dx, dy, *turned(b.pose[robot, 2]))
        dx, dy = to_outer(ahead, left, *turned(pose[2]))
        return np.array([pose[0] + dx, pose[1] + dy]), b.p[robot, area]

    def talk(self):
        """Stand still until the exchange is over and merged."""
        for _ in range(self.TICKS + 2):
            self.loop.step()
        assert not self.minds.exchange.is_valid.any()


@pytest.fixture(scope="session")
def pair():
    """Two robots that talk under a controller, with some numbers of the scenario changed."""
    return Pair


@pytest.fixture(scope="session")
def message():
    """A message about one or both areas: (distance, direction, p) of each, None if unknown."""

    def say(nest=None, prey=None):
        spoken = Message.array((1,)).view(np.recarray)[0]
        for area, estimate in ((NEST, nest), (PREY, prey)):
            if estimate is not None:
                spoken.has_estimate[area] = True
                spoken.distance[area], spoken.direction[area], spoken.p[area] = estimate
        return spoken

    return say
