"""Made-up scenes, and what stands in the arenas that they are drawn in."""

import numpy as np

from swarm_forage_env.scene import Scene, without_beliefs

OBSTACLES = [
    {"points": [[0.3, 0.25], [0.3, 0.45]], "radius": 0.02},
    {"points": [[-0.3, 0.4]], "radius": 0.1},
    {"points": [[-0.2, -0.5], [0.2, -0.5], [0.0, -0.3]], "is_closed": True},
]
CORNERS = [(-0.85, -0.6), (0.7, -0.6), (0.85, -0.45), (0.85, 0.6), (-0.85, 0.6)]
AREAS = [
    {"kind": "nest", "centre": [-0.7, 0.0]},
    {"kind": "nest", "centre": [-0.5, 0.4], "worth": 2.0},
    {"kind": "prey", "centre": [0.7, 0.3], "moves_at": 50.0, "moves_to": [0.7, -0.3]},
]


def scenes_of(loop, ticks):
    """The scenes of a loop now and after each of so many ticks."""
    found = [loop.scene()]
    for _ in range(ticks):
        loop.step()
        found.append(loop.scene())
    return found


def scene_of(pose, **changes):
    """Robots that explore without beliefs or messages, after a minute."""
    n = len(pose)
    usual = {"time": 60.0, "pose": np.array(pose, float), "messages": np.zeros((0, 2), np.int32)}
    return Scene(**without_beliefs(n) | usual | changes)
