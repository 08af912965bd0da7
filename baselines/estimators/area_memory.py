"""Area memory of social odometry: dead reckoning, finding an area, getting lost, choosing a goal.

Gutierrez et al. 2009 (TR), Sections 3 and 5.1.
"""

import math

from baselines.estimators.belief import NOBODY, NOWHERE, Belief, SocialMind
from swarm_forage_env.arrays import NEST, PREY, Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Readings
from swarm_forage_env.equations.differential_drive import advance, path_length
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.record import Numbers

NEST_BELOW, PREY_BELOW = 0.2, 0.68
"""Thresholds of a ground sensor: below the first it reads nest, below the second prey area."""


@kernel
def dead_reckon(belief: Belief, odometry: Float32[Array, "2"], axle: float) -> None:
    """Advance the believed pose by the odometry, and increase p by the path length.

        p = p + dd

    Source: TR, Eq. 7 and 13.
    """
    drho, dtheta = float(odometry[0]), float(odometry[1])
    if drho != 0.0 or dtheta != 0.0:
        x, y, theta = advance(belief.pose[0], belief.pose[1], belief.pose[2], drho, dtheta)
        belief.pose[0], belief.pose[1], belief.pose[2] = x, y, theta
        dd = path_length(drho, dtheta, axle)
        belief.p[NEST] += dd
        belief.p[PREY] += dd


@kernel
def area_under(ground: Float32[Array, "3"]) -> int:
    """Return the area that at least two of the three ground sensors read: NEST, PREY or NOWHERE."""
    nest = prey = 0
    for sensor in range(3):
        if ground[sensor] < NEST_BELOW:
            nest += 1
        elif ground[sensor] < PREY_BELOW:
            prey += 1
    if nest >= 2:
        return NEST
    return PREY if prey >= 2 else NOWHERE


@kernel
def find_areas(belief: Belief, ground: Float32[Array, "3"], to_centre: float) -> None:
    """Store the location of an area on entering it, and keep its p at 0 while the robot is on it.

    The stored point is `to_centre` [m] ahead: the centre, if the robot heads for it.
    """
    area = area_under(ground)
    if area != NOWHERE:
        belief.p[area] = 0.0
        if belief.on_area != area:
            c, s = cos_sin(belief.pose[2])
            dx, dy = to_outer(to_centre, 0.0, c, s)
            belief.location[area, 0] = belief.pose[0] + dx
            belief.location[area, 1] = belief.pose[1] + dy
            belief.known[area] = belief.visited[area] = True
            belief.came_from = area
            belief.search_path_left = -1.0
    belief.on_area = area


@kernel
def displacement_to(belief: Belief, area: int) -> tuple[float, float]:
    """Return the displacement from the robot to the believed location of an area, own frame [m]."""
    place, pose = belief.location[area], belief.pose
    return place[0] - pose[0], place[1] - pose[1]


@kernel
def notice_loss(belief: Belief, odometry: Float32[Array, "2"], numbers: Numbers) -> None:
    """Forget both areas if the goal is not found at its believed location.

    Within `lost_within` of the believed centre, the robot searches straight ahead for a path of
    `overshoot`. A lost robot ignores messages for a while: they may repeat the wrong estimate.

    Source: TR, Section 5.1 (reset of both locations).
    """
    belief.is_lost = False
    belief.ignore_ticks = max(belief.ignore_ticks - 1, 0)
    area = belief.goal
    if area == NOWHERE or not belief.known[area]:
        return
    if belief.search_path_left >= 0.0:
        belief.search_path_left -= abs(odometry[0])
        belief.is_lost = belief.search_path_left < 0.0
    else:
        dx, dy = displacement_to(belief, area)
        if hypot(dx, dy) < numbers.lost_within:
            belief.search_path_left = numbers.overshoot
    if belief.is_lost:
        belief.known[NEST] = belief.known[PREY] = False
        belief.visited[NEST] = belief.visited[PREY] = False
        belief.came_from = NOWHERE
        belief.search_path_left = -1.0
        belief.ignore_ticks = int(numbers.deaf_ticks)
        belief.partner = NOBODY


@kernel
def nearer_known(belief: Belief) -> int:
    """Return the nearer of the known areas, or NOWHERE if none is known."""
    best, nearest = NOWHERE, math.inf
    for area in range(2):
        if belief.known[area]:
            dx, dy = displacement_to(belief, area)
            if hypot(dx, dy) < nearest:
                best, nearest = area, hypot(dx, dy)
    return best


@kernel
def choose_goal(belief: Belief) -> None:
    """Set the goal: the area not visited last or, after a loss, the nearer one; only if known."""
    before = belief.goal
    if belief.came_from != NOWHERE:
        other = 1 - belief.came_from
        belief.goal = other if belief.known[other] else NOWHERE
    elif before == NOWHERE or not belief.known[before]:
        belief.goal = nearer_known(belief)
    if belief.goal != before:
        belief.search_path_left = -1.0


@kernel
def update_belief(mind: SocialMind, shared: Array, readings: Readings, numbers: Numbers) -> None:
    """Advance the belief by odometry, store areas found, detect a loss, and choose the goal."""
    dead_reckon(mind.belief, readings.odometry, numbers.axle)
    find_areas(mind.belief, readings.ground, numbers.to_centre)
    notice_loss(mind.belief, readings.odometry, numbers)
    choose_goal(mind.belief)
