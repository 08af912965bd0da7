"""How far off the beliefs of robots are, by NumPy: what compiled functions are compared with."""

import numpy as np

from swarm_forage_env.foraging.metrics import believed_places, nearest_areas


def localisation_error(loop):
    """Distance from where each robot believes an area to be to the nearest one [m].

    0 where it knows of none.
    """
    world, seen = loop.world, loop.situation
    places = believed_places(world.state.pose, seen.areas, seen.known)
    away = places - nearest_areas(world.worlds, places)
    return np.where(seen.known, np.hypot(away[:, :, 0], away[:, :, 1]), 0.0)
