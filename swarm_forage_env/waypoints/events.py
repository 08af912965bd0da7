"""What happened to each robot in a tick, for rewards of the user's own."""

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.record import Record, field
from swarm_forage_env.waypoints.world import WaypointsWorld


class Events(Record):
    """What happened to one robot in the last tick. Writer: `write_events`."""

    trip: bool = field(np.bool_)
    """It claimed its goal and was there."""

    loss: bool = field(np.bool_)
    """It claimed its goal and was not there."""

    message: int = field(np.int32)
    """Robots that it sees, and so hears."""


def write_events(world: WaypointsWorld, before: Array, out: Array) -> None:
    """Write what happened to the robots of these worlds since they were as `before`."""
    out["trip"] = world.robots["right"] > before["right"]
    out["loss"] = world.robots["wrong"] > before["wrong"]
    out["message"] = np.count_nonzero(world.sightings["seen"], axis=2)
