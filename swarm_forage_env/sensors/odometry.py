"""Wheel encoders: drifting odometry."""

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.kernels.odometry import read_odometry
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.state import SwarmState
from swarm_forage_env.streams import Cause, Streams


class Odometry:
    """Reads how far the wheels went. A robot that is pushed or blocked does not notice."""

    def __init__(self, scenario: Scenario) -> None:
        """Encoders of this scenario's noise."""
        self._dt = scenario.tick
        self._axle = scenario.robot.axle
        self._error = scenario.sensors.wheel_noise * scenario.robot.cruise_speed * scenario.tick

    def __call__(self, state: SwarmState, streams: Streams) -> Float32[Array, "rows 2"]:
        """Distance [m] and turn [rad] of each robot since the last tick."""
        reading = np.empty((len(state.wheels), 2), np.float32)
        encoders = streams[Cause.ENCODER]
        read_odometry(state.wheels, self._dt, self._axle, self._error, encoders, reading)
        return reading
