"""Kernels of social odometry, part one: moving, finding an area, getting lost, choosing a goal."""

import math

from baselines.estimators.beliefs import NOBODY, NOWHERE
from swarm_forage_env.arrays import NEST, PREY, Array, Bool, Float32, Float64, Int8, Int32
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.diff_drive import advance, path_length
from swarm_forage_env.kernels.frames import to_outer

NEST_BELOW, PREY_BELOW = 0.2, 0.68
"""A ground sensor under these sees the nest, the prey area: between black, grey and white."""


@kernel
def dead_reckon(
    odometry: Float32[Array, "rows 2"],
    axle: float,
    pose: Float64[Array, "rows 3"],
    p: Float64[Array, "rows areas"],
) -> None:
    """Move the believed pose by what the encoders tell, and let confidence wane with the path.

        p = p + dd

    Source: TR, Eq. 7 and 13.
    """
    for i in range(pose.shape[0]):
        drho, dtheta = float(odometry[i, 0]), float(odometry[i, 1])
        pose[i, 0], pose[i, 1], pose[i, 2] = advance(
            pose[i, 0], pose[i, 1], pose[i, 2], drho, dtheta
        )
        dd = path_length(drho, dtheta, axle)
        p[i, NEST] += dd
        p[i, PREY] += dd


@kernel
def area_under(ground: Float32[Array, "3"]) -> int:
    """The area that two of the three ground sensors see: NEST, PREY or NOWHERE."""
    nest = 0
    prey = 0
    for light in ground:
        if light < NEST_BELOW:
            nest += 1
        elif light < PREY_BELOW:
            prey += 1
    if nest >= 2:
        return NEST
    return PREY if prey >= 2 else NOWHERE


@kernel
def find_areas(  # noqa: PLR0913 inputs first, then what is updated
    ground: Float32[Array, "rows 3"],
    to_centre: float,
    pose: Float64[Array, "rows 3"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
    on_area: Int8[Array, " rows"],
    came_from: Int8[Array, " rows"],
    look_on: Float64[Array, " rows"],
) -> None:
    """Remember an area on entering it, and be sure of it (p = 0) while standing on it.

    The stored point lies `to_centre` [m] ahead: the centre, if the robot heads for it.
    """
    for i in range(pose.shape[0]):
        area = area_under(ground[i])
        if area != NOWHERE:
            p[i, area] = 0.0
            if on_area[i] != area:
                dx, dy = to_outer(to_centre, 0.0, pose[i, 2])
                location[i, area, 0] = pose[i, 0] + dx
                location[i, area, 1] = pose[i, 1] + dy
                known[i, area] = True
                came_from[i] = area
                look_on[i] = -1.0
        on_area[i] = area


@kernel
def notice_loss(  # noqa: PLR0913 inputs first, then what is updated
    odometry: Float32[Array, "rows 2"],
    parameters: Array,
    pose: Float64[Array, "rows 3"],
    location: Float64[Array, "rows areas 2"],
    known: Bool[Array, "rows areas"],
    came_from: Int8[Array, " rows"],
    goal: Int8[Array, " rows"],
    look_on: Float64[Array, " rows"],
    deaf: Int32[Array, " rows"],
    partner: Int32[Array, " rows"],
    lost: Bool[Array, " rows"],
) -> None:
    """Forget both areas at the place where the goal should be and is not.

    The place is reached within `lost_within` of the believed centre; from there the robot
    looks straight on for `overshoot` of path. Afterwards it is deaf for a while, or it would
    be handed the same wrong estimate straight back.

    Source: TR, Section 5.1 (reset of both locations).
    """
    for i in range(pose.shape[0]):
        lost[i] = False
        deaf[i] = max(deaf[i] - 1, 0)
        area = goal[i]
        if area == NOWHERE or not known[i, area]:
            continue
        if look_on[i] >= 0.0:
            look_on[i] -= abs(odometry[i, 0])
            lost[i] = look_on[i] < 0.0
        else:
            dx, dy = location[i, area, 0] - pose[i, 0], location[i, area, 1] - pose[i, 1]
            if math.hypot(dx, dy) < parameters[0]["lost_within"]:
                look_on[i] = parameters[0]["overshoot"]
        if lost[i]:
            known[i, :] = False
            came_from[i] = NOWHERE
            look_on[i] = -1.0
            deaf[i] = int(parameters[0]["deaf_ticks"])
            partner[i] = NOBODY


@kernel
def nearer_known(
    x: float, y: float, location: Float64[Array, "areas 2"], known: Bool[Array, " areas"]
) -> int:
    """The nearer of the known areas to (x, y), NOWHERE if none is known."""
    best, nearest = NOWHERE, math.inf
    for area in range(2):
        d = math.hypot(location[area, 0] - x, location[area, 1] - y)
        if known[area] and d < nearest:
            best, nearest = area, d
    return best


@kernel
def choose_goal(
    pose: Float64[Array, "rows 3"],
    location: Float64[Array, "rows areas 2"],
    known: Bool[Array, "rows areas"],
    came_from: Int8[Array, " rows"],
    goal: Int8[Array, " rows"],
    look_on: Float64[Array, " rows"],
) -> None:
    """From an area to the other; from nowhere to the nearer one known; else nowhere: wander."""
    for i in range(pose.shape[0]):
        before = goal[i]
        if came_from[i] != NOWHERE:
            other = 1 - came_from[i]
            goal[i] = other if known[i, other] else NOWHERE
        elif before == NOWHERE or not known[i, before]:
            goal[i] = nearer_known(pose[i, 0], pose[i, 1], location[i], known[i])
        if goal[i] != before:
            look_on[i] = -1.0
