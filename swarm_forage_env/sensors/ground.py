"""Three sensors under the front of the body that see how bright the floor is."""

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.kernels.ground import read_ground
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.state import SwarmState
from swarm_forage_env.streams import Cause, Streams


class Ground:
    """Reads the floor: nest black, prey area grey, the rest white."""

    def __init__(self, scenario: Scenario) -> None:
        """Sensors over this scenario's floor."""
        self._areas = scenario.areas
        self._radius = scenario.task.area_radius
        self._ahead = scenario.sensors.ground_ahead
        self._spacing = scenario.sensors.ground_spacing
        self._noise = scenario.sensors.ground_noise

    def __call__(self, state: SwarmState, streams: Streams) -> Float32[Array, "rows 3"]:
        """Brightness under the left, middle and right sensor of each robot."""
        reading = np.empty((len(state.pose), 3), np.float32)
        read_ground(
            state.pose,
            self._areas,
            self._radius,
            self._ahead,
            self._spacing,
            self._noise,
            streams[Cause.GROUND],
            reading,
        )
        return reading
