"""Whether a scenario has room: for its robots at the start, in a tick, and beside its obstacles."""

from collections.abc import Sequence

from swarm_forage_env.epuck.obstacles import ROUNDING, Obstacle, Point, check_clear
from swarm_forage_env.epuck.parts import Arena, Mission, Radio, Robot

MAX_START_DENSITY = 0.45
"""Share of the start circle that robots may cover; random placement jams at 0.547."""

MAX_STEP = 1.5
"""Way of a robot in a tick, at most, in radii: two that meet at twice that may overlap fully, so
that nobody can tell to which side they belong."""

MAX_CELLS, MAX_NEIGHBOURS = 10**7, 10**8
"""Sizes of the lists of neighbours of a world, which take 4 bytes for each."""

MAX_STEP_BY_OBSTACLES = 0.5
"""A robot drives less than this share of its radius in a tick where there are obstacles, so that
no contact moves its centre across a wall."""


def check_start(task: Mission, arena: Arena, radius: float) -> None:
    """ValueError if robots of this radius [m] would start outside the arena or too close."""
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


def check_speed(robot: Robot, tick: float) -> None:
    """ValueError if a robot could drive through another within a tick [s]."""
    limit = MAX_STEP * robot.radius / tick
    if robot.cruise_speed > limit + ROUNDING:
        raise ValueError(
            f"robot.cruise_speed={robot.cruise_speed}: at most {limit:g} [m/s], {MAX_STEP} radii of"
            f" {robot.radius} m in a tick of {tick} s, so that no robot drives through"
            " another; shorten tick"
        )


def check_memory(arena: Arena, robot: Robot, radio: Radio, n_robots: int) -> None:
    """ValueError for a world whose lists of neighbours would not fit into memory."""
    radius = robot.radius
    reach = max(radio.max_range, 2.0 * radius)
    if arena.length * arena.width / reach**2 > MAX_CELLS:
        raise ValueError(
            f"arena.length={arena.length}, arena.width={arena.width}: at most {MAX_CELLS} squares"
            f" of the radio's range, {reach:g} m; make the arena smaller or radio.max_range larger"
        )
    each = max(radio.slots, min(n_robots, 2.0 * (reach / radius + 1.0) ** 2))
    if n_robots * each > MAX_NEIGHBOURS:
        raise ValueError(
            f"task.n_robots={n_robots}: with {each:.0f} neighbours or slots each; robots times"
            f" neighbours may be at most {MAX_NEIGHBOURS}; take fewer robots, a smaller"
            " radio.max_range or fewer radio.slots"
        )


def check_obstacles(
    start_radius: float,
    robot: Robot,
    tick: float,
    every: Sequence[Obstacle],
    corners: Sequence[Point],
) -> None:
    """ValueError if obstacles reach into the start circle [m], or a robot could pass through."""
    way = robot.max_speed * tick
    if way > MAX_STEP_BY_OBSTACLES * robot.radius:
        fastest = MAX_STEP_BY_OBSTACLES * robot.radius / tick
        raise ValueError(
            f"robot.max_speed={robot.max_speed}: a robot could pass through a wall within a tick of"
            f" {tick} s; beside obstacles at most {fastest:g} [m/s]"
        )
    check_clear("the start circle", (0.0, 0.0), start_radius + robot.radius, every, corners)
