"""Eight infrared sensors that see robots and walls."""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.kernels.proximity import (
    SENSING_RANGE,
    read_proximity,
    sense_robots,
    sense_walls,
)
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.state import SwarmState
from swarm_forage_env.streams import Cause, Streams


class Proximity:
    """Reads how near the next robot or wall is in eight directions."""

    def __init__(self, scenario: Scenario, rows: int) -> None:
        """Sensors of this scenario's noise, for so many robots."""
        self.reach = 2.0 * scenario.robot.radius + SENSING_RANGE
        """Farthest other robot that can be seen, centre to centre [m]."""
        self._radius = scenario.robot.radius
        self._noise = scenario.sensors.proximity_noise
        self._distance: Float64[Array, "rows 8"] = np.zeros((rows, 8))

    def __call__(
        self, state: SwarmState, neighbours: Neighbours, streams: Streams
    ) -> Float32[Array, "rows 8"]:
        """One reading for each robot and sensor, in [0, 1]."""
        pairs, n_pairs = neighbours.pairs, neighbours.n_pairs
        reading = np.empty((len(state.pose), 8), np.float32)
        sense_walls(state.pose, neighbours.arena, self._radius, self._distance)
        sense_robots(state.pose, pairs, n_pairs, self._radius, self._distance)
        read_proximity(self._distance, self._noise, streams[Cause.PROXIMITY], reading)
        return reading
