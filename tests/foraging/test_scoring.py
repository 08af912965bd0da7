"""Foraging: the start, the round trip as an automaton, and the books."""

import itertools
import re

import numpy as np
import pytest
from scipy import stats

from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.epuck.tick import face
from swarm_forage_env.epuck.world import place_in_circle
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.foraging.scoring import TO_FIRST_NEST, next_leg, score
from swarm_forage_env.random_streams import NoiseSource, streams

RADIUS, APART = 0.2, 0.07
LETTER = {NEST: "N", PREY: "P", FLOOR: "-"}


def placed(n_robots, seed, radius=RADIUS):
    pose = np.full((n_robots, 3), np.nan)
    n = place_in_circle(radius, APART, streams([seed], n_robots, NoiseSource.PLACE), pose)
    return n, pose


def test_robots_start_inside_the_circle_and_apart():
    for seed in range(100):
        n, pose = placed(10, seed)
        assert n == 10
        assert np.hypot(pose[:, 0], pose[:, 1]).max() <= RADIUS
        assert np.all((pose[:, 2] >= -np.pi) & (pose[:, 2] < np.pi))
        d = np.hypot(*(pose[:, None, :2] - pose[None, :, :2]).transpose(2, 0, 1))
        assert d[np.triu_indices(10, 1)].min() >= APART


def test_places_and_headings_are_uniform(believable):
    x, y, heading = np.array([placed(1, seed)[1][0] for seed in range(5000)]).T
    believable(stats.kstest((x * x + y * y) / RADIUS**2, "uniform").pvalue)
    believable(stats.kstest(np.arctan2(y, x), stats.uniform(-np.pi, 2.0 * np.pi).cdf).pvalue)
    believable(stats.kstest(heading, stats.uniform(-np.pi, 2.0 * np.pi).cdf).pvalue)


def test_the_last_robot_placed_is_uniform_among_the_free_places(believable):
    # By symmetry: relative to the first, its direction is uniform.
    pose = np.array([placed(2, seed)[1] for seed in range(3000)])
    first = np.arctan2(pose[:, 0, 1], pose[:, 0, 0])
    last = np.arctan2(pose[:, 1, 1], pose[:, 1, 0])
    mirrored = np.sin(last - first)
    believable(stats.binomtest(int(np.sum(mirrored > 0.0)), len(mirrored)).pvalue)


def test_a_full_circle_tells_how_many_it_holds():
    n, pose = placed(50, 0, radius=0.1)
    assert 1 < n < 10
    assert np.isfinite(pose[:n]).all()


def trips_by_the_book(visits):
    """How often nest, prey, nest stand in a row, repeats and floor left out."""
    word = re.sub(r"(.)\1+", r"\1", "".join(LETTER[area] for area in visits).replace("-", ""))
    return len(re.findall("(?=NPN)", word))


def test_the_automaton_counts_what_stands_in_the_string_of_visits():
    for length in range(1, 7):
        for visits in itertools.product((NEST, PREY, FLOOR), repeat=length):
            leg, trips = TO_FIRST_NEST, 0
            for area in visits:
                leg, completed = next_leg(leg, area)
                trips += completed
            assert trips == trips_by_the_book(visits), visits


@entry_point
def keep_books(robots, worlds):
    """The score of every robot in a tick."""
    for w in range(worlds.shape[0]):
        worlds[w].ticks += 1
        for i in range(robots.shape[1]):
            face(robots[w, i])
            score(robots[w], i, worlds[w])


PLACES = {
    "nest": (-0.4 - 0.03, 0.0, 0.0),
    "prey": (0.4, 0.03, -np.pi / 2),
    "floor": (0.0, 0.0, 0.0),
    "beside": (-0.4, 0.08, np.pi / 2),  # the centre on the nest, the sensor not
}


@pytest.fixture
def book(block):
    """The score of one robot that is put down somewhere at each tick, in an episode of 8."""

    class Book:
        def __init__(self):
            self._block = block([PLACES["floor"]], area_distance=0.8, duration=0.8)
            self.robot = self._block.state[0]

        def tick(self, place, lost=False, known=(False, False)):
            self.robot.pose[:] = PLACES[place]
            self.robot.report.is_lost = lost
            self.robot.report.known[:] = known
            keep_books(self._block.robots, self._block.worlds)
            return float(self.robot.reward)

    return Book()


def test_a_round_trip_is_rewarded_in_the_tick_it_is_completed(book):
    way = ["floor", "nest", "floor", "prey", "prey", "floor", "nest", "nest", "prey", "nest"]
    rewards = [book.tick(place) for place in way]
    assert rewards == [0, 0, 0, 0, 0, 0, 1, 0, 0, 1]
    assert book.robot.round_trips == 2


def test_the_sensor_counts_and_not_the_centre(book):
    book.tick("beside")
    assert book.robot.first_visit.tolist() == [-1, -1]


def test_a_robot_is_on_the_path_while_it_knows_both_areas_in_the_second_half(book):
    both = True, True
    for _ in range(4):
        book.tick("floor", known=both)
    assert book.robot.path_ticks == 0  # the first half does not count
    book.tick("floor", known=both)
    book.tick("nest", known=both)
    assert book.robot.path_ticks == 2
    book.tick("prey", known=(True, False))
    book.tick("nest", known=(False, True))
    assert book.robot.path_ticks == 2  # where it is does not count
