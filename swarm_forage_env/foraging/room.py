"""Whether a scenario has room: for its areas, for its robots at the start, beside its obstacles."""

import math
from typing import TYPE_CHECKING

from swarm_forage_env.foraging.obstacles import ROUNDING, Point, check_clear

if TYPE_CHECKING:
    from swarm_forage_env.foraging.scenario import Scenario

MAX_START_DENSITY = 0.45
"""Share of the start circle that robots may cover; random placement jams at 0.547."""

MAX_STEP = 1.5
"""Way of a robot in a tick, at most, in radii: two that meet at twice that may overlap fully, so
that nobody can tell to which side they belong."""

MAX_CELLS, MAX_NEIGHBOURS = 10**7, 10**8
"""Sizes of the lists of neighbours of a world, which take 4 bytes for each."""

MOST_IN_A_TICK = 0.5
"""A robot drives less than this share of its radius in a tick where there are obstacles, so that
no contact moves its centre across a wall."""


def check_room(scenario: "Scenario") -> None:
    """ValueError if areas, starting places or obstacles of a scenario lie in each other's way."""
    if scenario.task.areas:
        _check_own_areas(scenario)
    else:
        _check_areas(scenario)
    _check_start(scenario)
    _check_speed(scenario)
    _check_memory(scenario)
    if scenario.obstacles or scenario.arena.corners:
        _check_obstacles(scenario)


def _check_speed(scenario: "Scenario") -> None:
    robot, limit = scenario.robot, MAX_STEP * scenario.robot.radius / scenario.tick
    if robot.cruise_speed > limit + ROUNDING:
        raise ValueError(
            f"robot.cruise_speed={robot.cruise_speed}: at most {limit:g} [m/s], {MAX_STEP} radii of"
            f" {robot.radius} m in a tick of {scenario.tick} s, so that no robot drives through"
            " another; shorten tick"
        )


def _check_memory(scenario: "Scenario") -> None:
    """ValueError for a world whose lists of neighbours would not fit into memory."""
    arena, radius, n_robots = scenario.arena, scenario.robot.radius, scenario.task.n_robots
    reach = max(scenario.radio.max_range, 2.0 * radius)
    if arena.length * arena.width / reach**2 > MAX_CELLS:
        raise ValueError(
            f"arena.length={arena.length}, arena.width={arena.width}: at most {MAX_CELLS} squares"
            f" of the radio's range, {reach:g} m; make the arena smaller or radio.max_range larger"
        )
    each = max(scenario.radio.slots, min(n_robots, 2.0 * (reach / radius + 1.0) ** 2))
    if n_robots * each > MAX_NEIGHBOURS:
        raise ValueError(
            f"task.n_robots={n_robots}: with {each:.0f} neighbours or slots each; robots times"
            f" neighbours may be at most {MAX_NEIGHBOURS}; take fewer robots, a smaller"
            " radio.max_range or fewer radio.slots"
        )


def _check_areas(scenario: "Scenario") -> None:
    task, arena = scenario.task, scenario.arena
    farthest = arena.length - 2.0 * task.area_radius
    if task.area_distance > farthest + ROUNDING or 2.0 * task.area_radius > arena.width:
        raise ValueError(
            f"task.area_distance={task.area_distance}, task.area_radius={task.area_radius}: areas"
            f" outside the arena of {arena.length} x {arena.width} m; area_distance may be at most"
            f" {farthest:g}, area_radius at most {arena.width / 2:g} [m]"
        )
    nearest = 2.0 * (task.start_radius + task.area_radius)
    if task.area_distance < nearest - ROUNDING:
        raise ValueError(
            f"task.area_distance={task.area_distance}: the areas reach into the start circle of"
            f" radius {task.start_radius} m; must be at least {nearest:g} [m]"
        )


def _check_own_areas(scenario: "Scenario") -> None:
    task, arena, places = scenario.task, scenario.arena, scenario.task.areas
    for number, area in enumerate(places):
        what = f"task.areas[{number}]: the {area.kind} area of radius {task.area_radius} m"
        for x, y in area.centres:
            far_x, far_y = 0.5 * arena.length, 0.5 * arena.width
            if max(abs(x) - far_x, abs(y) - far_y) + task.area_radius > ROUNDING:
                raise ValueError(
                    f"{what} about ({x:g}, {y:g}) lies outside the arena of {arena.length} x"
                    f" {arena.width} m; move it inside"
                )
            for other in range(number):
                if _nearest((x, y), places[other].centres) < 2.0 * task.area_radius - ROUNDING:
                    raise ValueError(
                        f"{what} about ({x:g}, {y:g}) overlaps task.areas[{other}], where that is"
                        " or moves to; keep them apart"
                    )
        if math.hypot(*area.centre) < task.start_radius + task.area_radius - ROUNDING:
            raise ValueError(
                f"{what} about ({area.centre[0]:g}, {area.centre[1]:g}) reaches into the start"
                f" circle of radius {task.start_radius} m; move it away from the origin"
            )


def _nearest(place: Point, others: list[Point]) -> float:
    """Distance from a place to the nearest of some others [m]."""
    return min(math.dist(place, other) for other in others)


def _check_start(scenario: "Scenario") -> None:
    task, arena, radius = scenario.task, scenario.arena, scenario.robot.radius
    widest = 0.5 * min(arena.length, arena.width) - radius
    if task.start_radius > widest + ROUNDING:
        raise ValueError(
            f"task.start_radius={task.start_radius}: robots would start outside the arena;"
            f" must be at most {widest:g} [m]"
        )
    fit = max(1, int(MAX_START_DENSITY * ((task.start_radius + radius) / radius) ** 2))
    if task.n_robots > fit:
        raise ValueError(
            f"task.n_robots={task.n_robots}: at most {fit} robots of radius {radius} m fit into the"
            f" start circle of radius {task.start_radius} m; enlarge task.start_radius"
        )


def _check_obstacles(scenario: "Scenario") -> None:
    task, robot, every = scenario.task, scenario.robot, scenario.obstacles
    way, corners = robot.max_speed * scenario.tick, scenario.arena.corners
    if way > MOST_IN_A_TICK * robot.radius:
        fastest = MOST_IN_A_TICK * robot.radius / scenario.tick
        raise ValueError(
            f"robot.max_speed={robot.max_speed}: a robot could pass through a wall within a tick of"
            f" {scenario.tick} s; beside obstacles at most {fastest:g} [m/s]"
        )
    check_clear("the start circle", (0.0, 0.0), task.start_radius + robot.radius, every, corners)
    for area in scenario.places:
        for centre in area.centres:
            check_clear(f"the {area.kind} area", centre, task.area_radius, every, corners)
