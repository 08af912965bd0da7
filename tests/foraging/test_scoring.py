"""Foraging: the start, the round trip as an automaton, and the books."""

import itertools
import re

import numpy as np
from scipy.spatial.distance import pdist

from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.epuck.placing import place_in_circle
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.foraging.scoring import TO_FIRST_NEST, next_leg
from swarm_forage_env.random_streams import NoiseSource, streams

RADIUS, APART = 0.2, 0.07
LETTER = {NEST: "N", PREY: "P", FLOOR: "-"}


def placed(n_robots, seed, radius=RADIUS):
    pose = np.full((n_robots, 3), np.nan)
    own = streams([seed], n_robots, NoiseSource.PLACE)
    return place_in_circle(radius, APART, own, pose), pose


def test_robots_start_inside_the_circle_and_apart():
    for seed in range(100):
        n, pose = placed(10, seed)
        assert n == 10
        assert np.hypot(pose[:, 0], pose[:, 1]).max() <= RADIUS
        assert np.all((pose[:, 2] >= -np.pi) & (pose[:, 2] < np.pi))
        assert pdist(pose[:, :2]).min() >= APART


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
