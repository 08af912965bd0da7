"""A scenario of e-pucks: every number that a world of them has, whatever their task is."""

import json
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.epuck.faults import Faults
from swarm_forage_env.epuck.obstacles import Obstacle
from swarm_forage_env.epuck.parts import Arena, Mission, Radio, Robot, Sensors
from swarm_forage_env.epuck.room import check_memory, check_obstacles, check_speed, check_start
from swarm_forage_env.parameters import MIN_TICK, BaseScenario, Positive

AN_OBSTACLE = '[{"points": [[0.4, -0.1], [0.4, 0.1]], "radius": 0.01}]'


class EpuckScenario(BaseScenario):
    """Everything that fixes a world of e-pucks but its seed; a task replaces `task` by its own."""

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

    @field_validator("obstacles", mode="before")
    @classmethod
    def _from_text(cls, obstacles: Any) -> Any:  # noqa: ANN401 whatever was given
        """Obstacles as they are written on a command line, in JSON."""
        if not isinstance(obstacles, str):
            return obstacles
        try:
            return json.loads(obstacles)
        except json.JSONDecodeError:
            raise ValueError(
                f"obstacles={obstacles}: must be a list in JSON, as {AN_OBSTACLE}"
            ) from None

    @model_validator(mode="after")
    def _has_room_for_robots(self) -> Self:
        task, robot, arena = self.task, self.robot, self.arena
        check_start(task, arena, robot.radius)
        check_speed(robot, self.tick)
        check_memory(arena, robot, self.radio, task.n_robots)
        if self.obstacles or arena.corners:
            check_obstacles(task.start_radius, robot, self.tick, self.obstacles, arena.corners)
        self.faults.check_robots(task.n_robots)
        return self

    @property
    def falsifying(self) -> tuple[str, ...]:
        """What in it changes the messages of robots, by dotted name."""
        return self.faults.falsifying

    @property
    def areas(self) -> Float64[Array, "areas 2"]:
        """Centres of the areas on the floor at the start, world frame [m]; here none."""
        return np.zeros((0, 2))

    @property
    def area_radius(self) -> float:
        """Radius of these areas [m]."""
        return 0.0

    @property
    def false_place_distance(self) -> float:
        """How far from the true place a place that liars agree on is at least [m]."""
        return 0.0
