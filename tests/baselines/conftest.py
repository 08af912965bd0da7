"""Fixtures of the controllers' tests: what robots sense and hear, written by hand."""

import numpy as np
import pytest

import baselines.recipes  # noqa: F401 enters the controllers
from baselines.estimators.social_odometry import SocialOdometryParameters
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.interface import WORDS, Encounter, Heard, Readings, Situation
from swarm_forage_env.scenarios import find_scenario

SLOTS = 2
GROUND = {"floor": 1.0, "nest": 0.0, "prey": 0.5}


@pytest.fixture
def encounter():
    """An encounter of one robot for each given own and heard p [m] of the nest."""

    def make(own_p, heard_p):
        own_p, heard_p = np.broadcast_arrays(own_p, heard_p)
        rows = own_p.size
        p = np.zeros((2, rows, 2), np.float32)
        p[0, :, NEST], p[1, :, NEST] = own_p.ravel(), heard_p.ravel()
        both = np.tile([True, False], (rows, 1))
        return Encounter(
            valid=np.ones(rows, np.bool_),
            own_p=p[0],
            heard_p=p[1],
            own_known=both,
            heard_known=both,
            disagreement=np.zeros((rows, 2), np.float32),
            own_distance=np.zeros((rows, 2), np.float32),
            heard_distance=np.zeros((rows, 2), np.float32),
            range=np.full(rows, 0.1, np.float32),
            frames=np.full(rows, 10.0, np.float32),
            goal=np.zeros(rows, np.int8),
        )

    return make


class Believers:
    """Robots of one world, told tick by tick what they sense and hear."""

    def __init__(self, n_robots, **parameters):
        n = {"n_robots": n_robots, "start_radius": 0.3}
        self.scenario = find_scenario("es1", n | {"exchange_time": 0.5})
        self.n_robots = n_robots
        self.estimator = SocialOdometryParameters(**parameters).start(self.scenario, 1)
        self.beliefs = self.estimator.beliefs

    def sense(self, distance=0.0, turn=0.0, ground="floor", messages=()):
        """One tick of the same readings for all; messages are (receiver, sender, words, beam)."""
        n = self.n_robots
        heard = Heard(
            valid=np.zeros((n, SLOTS), np.bool_),
            sender=np.zeros((n, SLOTS), np.int32),
            words=np.zeros((n, SLOTS, WORDS), np.float32),
            beam=np.zeros((n, SLOTS, 3), np.float32),
            frames=np.zeros((n, SLOTS), np.int32),
        )
        for receiver, sender, words, beam in messages:
            slot = int(heard.valid[receiver].sum())
            heard.valid[receiver, slot] = True
            heard.sender[receiver, slot] = sender
            heard.words[receiver, slot] = words
            heard.beam[receiver, slot] = beam
            heard.frames[receiver, slot] = 10
        readings = Readings(
            proximity=np.zeros((n, 8), np.float32),
            ground=np.full((n, 3), GROUND[ground], np.float32),
            odometry=np.tile(np.array([distance, turn], np.float32), (n, 1)),
        )
        self.estimator.observe(readings, heard, np.zeros((n, 2), np.float32))
        return self.estimator.encounter.valid.copy()

    def know(self, robot, area, x, y, p, came_from=False):
        """Give a robot an estimate, in its own frame."""
        self.beliefs.location[robot, area] = x, y
        self.beliefs.p[robot, area] = p
        self.beliefs.known[robot, area] = True
        if came_from:
            self.beliefs.came_from[robot] = area


@pytest.fixture
def believers():
    return Believers


@pytest.fixture
def words():
    """A message about one or both areas: (distance, direction, p) of each, None if unknown."""

    def say(nest=None, prey=None):
        spoken = np.zeros(WORDS, np.float32)
        for area, told in ((NEST, nest), (PREY, prey)):
            if told is not None:
                spoken[4 * area : 4 * area + 4] = (1.0, *told)
        return spoken

    return say


@pytest.fixture
def situation():
    """A situation of so many robots that see, know and hear nothing, with some of it changed."""

    def make(rows=1, **changed):
        arrays = {
            "proximity": np.zeros((rows, 8), np.float32),
            "ground": np.ones((rows, 3), np.float32),
            "target": np.zeros((rows, 2), np.float32),
            "areas": np.zeros((rows, 2, 2), np.float32),
            "p": np.zeros((rows, 2), np.float32),
            "known": np.zeros((rows, 2), np.bool_),
            "goal": np.full(rows, -1, np.int8),
            "talking": np.zeros(rows, np.bool_),
            "heard": np.zeros((rows, SLOTS), np.bool_),
            "beam": np.zeros((rows, SLOTS, 3), np.float32),
            "wheels": np.zeros((rows, 2), np.float32),
        }
        for name, value in changed.items():
            arrays[name][:] = value
        return Situation(**arrays)

    return make
