"""How far off the beliefs of robots are, by NumPy: what compiled functions are compared with."""

import numpy as np

from swarm_forage_env.foraging.metrics import nearest_areas


def localisation_error(loop):
    """Distance from the believed to the nearest true place of an area [m]; 0 if unknown."""
    world, seen = loop.world, loop.situation
    x, y, theta = world.state.pose.T[..., None]
    c, s, (ahead, left) = np.cos(theta), np.sin(theta), np.moveaxis(seen.areas, 2, 0)
    places = np.stack([x + c * ahead - s * left, y + s * ahead + c * left], axis=2)
    away = places - nearest_areas(world.worlds, places)
    return np.where(seen.known, np.hypot(away[:, :, 0], away[:, :, 1]), 0.0)
