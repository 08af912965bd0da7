"""SwarmState: the ground truth, a structure of arrays with one writer each.

A row is a robot; a world is a block of N consecutive rows.
"""

from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32, Int64, checked
from swarm_forage_env.interface import WORDS


@checked
@dataclass(frozen=True, slots=True)
class SwarmState:
    """What is true in W worlds of N robots. Controllers never see it."""

    pose: Float64[Array, "rows 3"]
    """x, y [m] and heading [rad] in the world frame. Writer: physics; the scenario at reset."""

    wheels: Float64[Array, "rows 2"]
    """Speed of the left and right wheel in the last tick [m/s]. Writer: World.tick."""

    words: Float32[Array, "rows words"]
    """What each robot broadcast in the last tick. Writer: World.tick."""

    speaking: Bool[Array, " rows"]
    """The robot broadcast in the last tick. Writer: World.tick."""

    ticks: Int64[Array, " worlds"]
    """Ticks since reset. Writer: World.tick."""

    leg: Int8[Array, " rows"]
    """0: nest not yet visited; 1: on the way to the prey; 2: on the way back. Writer: score."""

    round_trips: Int32[Array, " rows"]
    """Completed trips nest -> prey -> nest. Writer: score."""

    first_visit: Int64[Array, "rows areas"]
    """Tick of the first visit to each area, -1 before it. Writer: score."""

    known: Bool[Array, "rows areas"]
    """The robot reports that it knows where the area is. Writer: World.tick."""

    path_ticks: Int64[Array, " rows"]
    """Ticks on the path in the second half of the episode. Writer: score."""

    lost_events: Int32[Array, " rows"]
    """How often the robot reported itself lost. Writer: score."""

    messages: Int32[Array, " rows"]
    """Messages heard. Writer: the radio."""


def empty_state(n_worlds: int, n_robots: int) -> SwarmState:
    """The arrays of W worlds of N robots, all at rest at the origin, before any reset."""
    rows = n_worlds * n_robots
    return SwarmState(
        pose=np.zeros((rows, 3)),
        wheels=np.zeros((rows, 2)),
        words=np.zeros((rows, WORDS), np.float32),
        speaking=np.zeros(rows, np.bool_),
        ticks=np.zeros(n_worlds, np.int64),
        leg=np.zeros(rows, np.int8),
        round_trips=np.zeros(rows, np.int32),
        first_visit=np.full((rows, 2), -1, np.int64),
        known=np.zeros((rows, 2), np.bool_),
        path_ticks=np.zeros(rows, np.int64),
        lost_events=np.zeros(rows, np.int32),
        messages=np.zeros(rows, np.int32),
    )
