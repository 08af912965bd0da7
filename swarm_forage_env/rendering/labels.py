"""Places for names in a picture: never over a robot, nor beyond the arena."""

from collections.abc import Sequence

import numpy as np
import pygame

from swarm_forage_env.arrays import Array, Float64


def places_about(
    centre: tuple[float, float], size: tuple[int, int], radius: float, is_inside: bool
) -> list[pygame.Rect]:
    """Where a name of this size may stand at a circle [px], the best first.

    In its middle, if there is room inside; above, below, right, left, and at the corners.
    """
    x, y = centre
    across, along = radius + 0.6 * size[1], radius + 0.6 * size[0]
    away = [(0.0, 0.0)] if is_inside else []
    away += [(0.0, -across), (0.0, across), (along, 0.0), (-along, 0.0)]
    away += [(side * along, end * across) for side in (1.0, -1.0) for end in (-1.0, 1.0)]
    found = [pygame.Rect((0, 0), size) for _ in away]
    for rect, (right, down) in zip(found, away, strict=True):
        rect.center = round(x + right), round(y + down)
    return found


def is_free(
    place: pygame.Rect,
    arena: pygame.Rect,
    robots: Float64[Array, "robots 2"],
    radius: float,
    taken: Sequence[pygame.Rect],
) -> bool:
    """Whether a name can stand there: inside the arena, off all robots and other names [px]."""
    if not arena.contains(place) or place.collidelist(list(taken)) >= 0:
        return False
    nearest = np.clip(robots, place.topleft, place.bottomright)
    return bool((np.hypot(*(robots - nearest).T) > radius).all())
