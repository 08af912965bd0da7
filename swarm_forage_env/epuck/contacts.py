"""Contacts: separation of robots that overlap a robot, an obstacle or a wall."""

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.surroundings import COUNT, FIRST, Neighbours
from swarm_forage_env.equations.contacts import (
    GENTLE_PASSES,
    HALF,
    MAX_PASSES,
    OVER_RELAXED,
    OVERLAP,
    keep_inside,
    separate_pair,
)
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import Pose
from swarm_forage_env.equations.obstacles import Capsules, from_axis, keep_out


@kernel
def is_near_walls(robot: EpuckState, world: EpuckWorldState, gap: float) -> bool:
    """Return whether a robot's body is within `gap` [m] of a wall of the arena."""
    far = world.radius + gap
    x, y = abs(robot.pose[0]), abs(robot.pose[1])
    return bool(x >= 0.5 * world.arena[0] - far or y >= 0.5 * world.arena[1] - far)


@kernel
def is_near_obstacle(
    robot: EpuckState, world: EpuckWorldState, obstacles: Capsules, gap: float
) -> bool:
    """Return whether a robot's body is within `gap` [m] of an obstacle."""
    far = world.radius + gap
    for k in range(obstacles.shape[0]):
        dx, dy = from_axis(robot.pose[0], robot.pose[1], obstacles[k])
        if hypot(dx, dy) <= far + obstacles[k, 4]:
            return True
    return False


@kernel
def keep_out_of_all(pose: Pose, obstacles: Capsules, radius: float) -> float:
    """Move a robot out of every obstacle in turn, in place; return the largest overlap [m]."""
    worst = 0.0
    for k in range(obstacles.shape[0]):
        worst = max(worst, keep_out(pose, obstacles[k], radius))
    return worst


@kernel
def keep_all_clear(swarm: Array, world: EpuckWorldState, obstacles: Capsules) -> float:
    """Move every robot inside the walls, then out of obstacles; return the largest overlap [m]."""
    for i in range(swarm.shape[0]):
        keep_inside(swarm[i].pose, world.arena, world.radius)
    worst = 0.0
    for i in range(swarm.shape[0]):
        worst = max(worst, keep_out_of_all(swarm[i].pose, obstacles, world.radius))
    return worst


@kernel
def separate_all(
    swarm: Array, near: Neighbours, world: EpuckWorldState, obstacles: Capsules, share: float
) -> float:
    """Move both robots of each overlapping pair apart by a share; return the largest overlap [m].

    Each moved robot is at once moved out of the obstacles, so that several moves cannot carry its
    centre across a wall.
    """
    worst = 0.0
    for i in range(swarm.shape[0]):
        for k in range(FIRST, FIRST + near[i, COUNT]):
            j = near[i, k]
            if j >= i:
                break
            short = separate_pair(swarm[i].pose, swarm[j].pose, 2.0 * world.radius, share)
            worst = max(worst, short)
            if short > 0.0:
                keep_out_of_all(swarm[i].pose, obstacles, world.radius)
                keep_out_of_all(swarm[j].pose, obstacles, world.radius)
    return worst


@kernel
def resolve_contacts(
    swarm: Array, near: Neighbours, world: EpuckWorldState, obstacles: Capsules
) -> bool:
    """Move overlapping robots apart, out of the obstacles and back inside the walls, in place.

    Each pass moves every robot inside the walls and out of the obstacles, then both robots of an
    overlapping pair by half the overlap, in a clump by more, until no overlap exceeds OVERLAP.
    Returns false if MAX_PASSES were not enough.
    """
    for n_passes in range(MAX_PASSES):
        overlap = keep_all_clear(swarm, world, obstacles)
        share = HALF if n_passes < GENTLE_PASSES else OVER_RELAXED
        worst = separate_all(swarm, near, world, obstacles, share)
        if max(worst, overlap) <= OVERLAP:
            if worst > 0.0:
                keep_all_clear(swarm, world, obstacles)
            return True
    keep_all_clear(swarm, world, obstacles)
    return False
