"""Scenario of e-pucks: all parameters of a world that do not depend on the task."""

from typing import ClassVar, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.epuck.faults import Faults
from swarm_forage_env.epuck.obstacles import (
    ROUNDING,
    Obstacle,
    Point,
    capsules_of,
    distance_from,
    is_inside,
)
from swarm_forage_env.epuck.parts import Arena, Mission, Radio, Robot, Sensors
from swarm_forage_env.parameters import MIN_TICK, BaseScenario, Positive, list_as

MAX_START_DENSITY = 0.45
"""Share of the start circle that robots may cover; random placement jams at 0.547."""

MAX_STEP = 1.5
"""Largest path of a robot in a tick, in radii. With a longer one, two robots that meet could
overlap fully, so that their sides cannot be told apart."""

MAX_CELLS, MAX_NEIGHBOURS = 10**7, 10**8
"""Largest sizes of the neighbour lists of a world, with 4 bytes per entry."""

MAX_STEP_BY_OBSTACLES = 0.5
"""Largest path of a robot in a tick in a world with obstacles, in radii, so that no contact moves
its centre across a wall."""


class EpuckScenario(BaseScenario):
    """Parameters of a world of e-pucks; a task replaces `task` by a subclass of it."""

    fixed: ClassVar[tuple[str, ...]] = ("task.n_robots", "radio.slots")

    name: str = Field("custom", min_length=1, description="Name in tables and data")
    arena: Arena = Arena()
    robot: Robot = Robot()
    sensors: Sensors = Sensors()
    radio: Radio = Radio()
    task: Mission = Mission()
    faults: Faults = Faults()
    tick: Positive = Field(0.1, ge=MIN_TICK, description="Control period [s]. TR 5 (published)")
    obstacles: tuple[Obstacle, ...] = Field(
        (), description="Discs and walls inside the arena [m]. Not in the papers (chosen)"
    )

    _from_text = field_validator("obstacles", mode="before")(
        list_as('[{"points": [[0.4, -0.1], [0.4, 0.1]], "radius": 0.01}]')
    )

    @model_validator(mode="after")
    def _has_room_for_robots(self) -> Self:
        self._check_start()
        self._check_speed()
        self._check_memory()
        if self.obstacles or self.arena.corners:
            clear = self.task.start_radius + self.robot.radius
            self._check_clear("the start circle", (0.0, 0.0), clear)
        self.faults.check_robots(self.task.n_robots)
        self.check_areas()
        return self

    def check_areas(self) -> None:
        """Raise ValueError for areas outside the arena, on each other, or on an obstacle."""
        radius, half = self.area_radius, 0.5 * np.array([self.arena.length, self.arena.width])
        remedy = "change the parameters of task that place it"
        for number, centre in enumerate(self.areas):
            where = f"the area about ({centre[0]:g}, {centre[1]:g}) with radius {radius:g} m"
            if (np.abs(centre) + radius > half + ROUNDING).any():
                raise ValueError(f"{where} lies outside the arena; {remedy}")
            if (np.hypot(*(self.areas[:number] - centre).T) < 2.0 * radius - ROUNDING).any():
                raise ValueError(f"{where} overlaps another one; {remedy}")
            self._check_clear("the area", (float(centre[0]), float(centre[1])), radius)

    def _check_start(self) -> None:
        """Raise ValueError if robots would start outside the arena or too close to each other."""
        task, arena, radius = self.task, self.arena, self.robot.radius
        widest = 0.5 * min(arena.length, arena.width) - radius
        larger = f"arena.length and arena.width must be above {2.0 * radius:g}"
        remedy = f"must be at most {widest:g}" if widest > 0.0 else larger
        if task.start_radius > widest + ROUNDING:
            raise ValueError(
                f"task.start_radius={task.start_radius}: robots would start outside the arena;"
                f" {remedy} [m]"
            )
        fit = max(1, int(MAX_START_DENSITY * ((task.start_radius + radius) / radius) ** 2))
        if task.n_robots > fit:
            raise ValueError(
                f"task.n_robots={task.n_robots}: at most {fit} robots of radius {radius} m fit into"
                f" the start circle of radius {task.start_radius} m; enlarge task.start_radius"
            )

    def _check_speed(self) -> None:
        """Raise ValueError if a robot could pass through another one or a wall within a tick."""
        robot, tick = self.robot, self.tick
        limit = MAX_STEP * robot.radius / tick
        if robot.cruise_speed > limit + ROUNDING:
            raise ValueError(
                f"robot.cruise_speed={robot.cruise_speed}: at most {limit:g} [m/s], {MAX_STEP}"
                f" radii of {robot.radius} m in a tick of {tick} s, so that no robot drives through"
                " another; shorten tick"
            )
        fastest = MAX_STEP_BY_OBSTACLES * robot.radius / tick
        if (self.obstacles or self.arena.corners) and robot.max_speed > fastest:
            raise ValueError(
                f"robot.max_speed={robot.max_speed}: a robot could pass through a wall within a"
                f" tick of {tick} s; with obstacles at most {fastest:g} [m/s]"
            )

    def _check_memory(self) -> None:
        """Raise ValueError if the neighbour lists would not fit into memory."""
        arena, radius, n_robots = self.arena, self.robot.radius, self.task.n_robots
        reach = max(self.radio.max_range, 2.0 * radius)
        if arena.length * arena.width / reach**2 > MAX_CELLS:
            raise ValueError(
                f"arena.length={arena.length}, arena.width={arena.width}: the arena may cover at"
                f" most {MAX_CELLS} squares with sides of the radio's range, {reach:g} m; make"
                " the arena smaller or radio.max_range larger"
            )
        each = max(self.radio.slots, min(n_robots, 2.0 * (reach / radius + 1.0) ** 2))
        if n_robots * each > MAX_NEIGHBOURS:
            raise ValueError(
                f"task.n_robots={n_robots}: with {each:.0f} neighbours or message slots each;"
                f" robots times neighbours may be at most {MAX_NEIGHBOURS}; use fewer robots, a"
                " smaller radio.max_range or fewer radio.slots"
            )

    def _check_clear(self, subject: str, centre: Point, radius: float) -> None:
        """Raise ValueError if a circle [m] overlaps an obstacle or is not inside the outer wall."""
        corners = self.arena.corners
        where = f"{subject} about ({centre[0]:g}, {centre[1]:g}) with radius {radius:g} m"
        if corners and not is_inside(centre, corners):
            raise ValueError(f"{where} lies outside of arena.corners; move it inside")
        for number, obstacle in enumerate(self.obstacles):
            closed = obstacle.is_closed and is_inside(centre, obstacle.points)
            if closed or distance_from(centre, capsules_of([obstacle], ())) < radius - ROUNDING:
                raise ValueError(
                    f"{where} overlaps obstacles[{number}] at {list(obstacle.points)}; move one of"
                    " them"
                )
        if distance_from(centre, capsules_of((), corners)) < radius - ROUNDING:
            raise ValueError(f"{where} overlaps the wall along arena.corners; move it inside")

    @property
    def falsifying(self) -> tuple[str, ...]:
        """Faults in the scenario that change messages, by dotted name."""
        kinds = {"liar": self.faults.liar, "stale": self.faults.stale}
        return tuple(f"faults.{name}" for name, kind in kinds.items() if kind.is_any)

    @property
    def areas(self) -> Float64[Array, "areas 2"]:
        """Centres of the areas at the start, world frame [m]; none unless a task defines them.

        They lie inside the arena and apart from each other, unless the task has another
        `check_areas`.
        """
        return np.zeros((0, 2))

    @property
    def area_radius(self) -> float:
        """Radius of these areas [m]."""
        return 0.0

    @property
    def false_place_distance(self) -> float:
        """Smallest distance of a place that liars agree on from the true place [m]."""
        return 0.0
