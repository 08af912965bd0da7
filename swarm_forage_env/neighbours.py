"""The pairs of robots close enough to touch, to sense or to hear each other."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int32, Int64
from swarm_forage_env.kernels.neighbours import EMPTY, find_pairs
from swarm_forage_env.scenario import Scenario

SLACK = 0.02
"""Pairs are kept this much beyond the reach [m], so that settling contacts adds none."""


class Neighbours:
    """Pairs of rows within reach, found once a tick and shared by contacts and sensors."""

    def __init__(self, scenario: Scenario, n_worlds: int, reach: float) -> None:
        """A grid for worlds of this scenario; reach is centre to centre [m]."""
        n_robots = scenario.task.n_robots
        self.reach = reach + SLACK
        self.arena: Float64[Array, 2] = np.array([scenario.arena.length, scenario.arena.width])
        self.pairs: Int32[Array, "capacity 2"] = np.zeros((4 * n_worlds * n_robots, 2), np.int32)
        self.start: Int64[Array, " worlds_and_end"] = np.zeros(n_worlds + 1, np.int64)
        self.n_pairs = 0
        self._n_robots = n_robots
        cells = [max(1, math.floor(side / self.reach)) for side in self.arena]
        self._head: Int32[Array, "cells_x cells_y"] = np.full(cells, EMPTY, np.int32)
        self._following: Int32[Array, " robots"] = np.zeros(n_robots, np.int32)

    def find(self, pose: Float64[Array, "rows 3"]) -> None:
        """Fill `pairs` and `start` for these poses; the room for pairs grows as needed."""
        while True:
            n_pairs = find_pairs(
                pose,
                self._n_robots,
                self.arena,
                self.reach,
                self._head,
                self._following,
                self.pairs,
                self.start,
            )
            if n_pairs <= len(self.pairs):
                self.n_pairs = n_pairs
                return
            self.pairs = np.zeros((2 * n_pairs, 2), np.int32)
