"""A scenario: every number of the world, with unit, meaning and origin, in frozen models.

Origin is one of: published (the paper says so), derived (follows from what a paper says),
chosen (no paper says; see the description). TR is Gutierrez et al. 2009, ANTS is
Gutierrez et al. 2008.
"""

import math
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.foraging.areas import Area, check_areas, in_order
from swarm_forage_env.foraging.faults import Faults
from swarm_forage_env.foraging.obstacles import Obstacle, Point, check_corners
from swarm_forage_env.foraging.room import check_room
from swarm_forage_env.parameters import (
    MIN_TICK,
    Count,
    NotNegative,
    Part,
    Positive,
    Share,
    check_duration,
)


class Arena(Part):
    """The walled floor, its centre at the origin, x along the long side."""

    length: Positive = Field(1.7, description="Side along x [m]. TR Table 2 (published)")
    width: Positive = Field(1.2, description="Side along y [m]. TR Table 2 (published)")
    corners: tuple[Point, ...] = Field(
        (),
        description="Corners of an outer wall inside that rectangle, in order [m]; none: the"
        " rectangle is the outer wall. Not in the papers (chosen)",
    )

    @model_validator(mode="after")
    def _has_its_corners_inside(self) -> Self:
        check_corners(self.corners, self.length, self.width)
        return self


class Robot(Part):
    """The e-puck: a disc on two wheels."""

    radius: Positive = Field(0.035, ge=1e-3, description="Body radius [m]. TR 6.1 (published)")
    axle: Positive = Field(
        0.053, ge=1e-3, description="Distance between the wheels [m]. TR 3.1 (published)"
    )
    max_speed: Positive = Field(
        0.129,
        description="Wheel speed the motors reach [m/s]: 1 turn/s, 41 mm wheel. TR 3.1 (published)",
    )
    cruise_speed: Positive = Field(
        0.06, description="Wheel speed of a full-speed command [m/s]. Not in the papers (derived)"
    )

    @model_validator(mode="after")
    def _cruises_below_its_limit(self) -> Self:
        if self.cruise_speed > self.max_speed:
            raise ValueError(
                f"cruise_speed={self.cruise_speed}: at most max_speed={self.max_speed} [m/s]"
            )
        return self


class Sensors(Part):
    """The robot's own sensors and their noise."""

    proximity_noise: Share = Field(
        0.2, description="Infrared reading x (1 +- this), uniform. TR 6.1 (published)"
    )
    ground_noise: Share = Field(
        0.3, description="Ground reading x (1 +- this), uniform. TR 6.1 (published)"
    )
    ground_ahead: NotNegative = Field(
        0.03, description="Ground sensors ahead of the centre [m]. ARGoS e-puck (published)"
    )
    ground_spacing: NotNegative = Field(
        0.009, description="Ground sensors to the left and right [m]. ARGoS e-puck (published)"
    )
    wheel_noise: Share = Field(
        0.058,
        description="Each turning wheel's path is misread by +- this share of the cruise speed's"
        " path in a tick, uniform. ANTS 4.1 gives the form; the size is derived",
    )


class Radio(Part):
    """The range-and-bearing board: who hears whom, and how badly."""

    max_range: Positive = Field(
        0.15, description="Farthest sender heard, centre to centre [m]. TR 6.1 (published)"
    )
    near: NotNegative = Field(
        0.01, description="Up to here only loss_near is lost [m]. TR 6.1 (published)"
    )
    loss_near: Share = Field(0.01, description="Messages lost at `near`. TR 6.1 (published)")
    loss_far: Share = Field(
        0.5, description="Messages lost at max_range, linear between. TR 6.1 (published)"
    )
    range_noise: NotNegative = Field(
        0.025, description="One frame's range +- this, uniform [m]. TR 6.1 (published)"
    )
    bearing_noise: NotNegative = Field(
        math.radians(20.0),
        le=math.pi,
        description="One frame's bearing +- this, uniform, at either end [rad]. TR 6.1 (published)",
    )
    range_model: Literal["uniform", "board"] = Field(
        "uniform",
        description="uniform: range_noise. board: range from the received power of the real"
        " board, lognormal (argos3-epuck; published in code)",
    )
    frames: Count = Field(
        2,
        le=10_000,
        description="Messages averaged into one reading while the receiver stands still; one"
        " when it moves. An area is three words of 9.2 ms (board firmware), and the partner"
        " speaks as long: two fit into a tick (derived)",
    )
    slots: Count = Field(
        4,
        le=10_000,
        description="Messages heard in a tick, at most, drawn at random. ARGoS: up to 5 (chosen)",
    )
    exchange_time: Positive = Field(
        0.4, description="How long an exchange takes [s]. Not in the papers (derived)"
    )
    is_shadowed: bool = Field(
        False,
        description="A message is lost where an obstacle lies between sender and receiver. Not in"
        " the papers (chosen)",
    )

    @property
    def is_board(self) -> bool:
        """Range comes from received power, as on the real board."""
        return self.range_model == "board"

    @model_validator(mode="after")
    def _loses_more_farther_away(self) -> Self:
        if self.near >= self.max_range:
            raise ValueError(f"near={self.near}: must be below max_range={self.max_range} [m]")
        if self.loss_near > self.loss_far:
            raise ValueError(
                f"loss_near={self.loss_near}: must be at most loss_far={self.loss_far}"
            )
        return self


class Task(Part):
    """Foraging: where the areas are, how many robots, for how long."""

    n_robots: Count = Field(10, description="Robots. TR Table 2 (published)")
    duration: Positive = Field(
        1800.0, description="Length of an episode [s]. TR Table 2 (published)"
    )
    area_radius: Positive = Field(
        0.1, description="Radius of the nest and of the prey area [m]. TR Table 2 (published)"
    )
    area_distance: Positive = Field(
        1.5,
        description="Distance between the centres of nest and prey [m], which lie on the long"
        " axis, symmetric about the centre. Not in the papers (derived)",
    )
    start_radius: Positive = Field(
        0.2,
        description="Robots start with their centres in this circle about the arena's centre"
        " [m]. TR Table 2 (published)",
    )
    areas: tuple[Area, ...] = Field(
        (),
        description="Nests and prey areas, their centres in [m], instead of the two that"
        " area_distance sets; none: those two. Not in the papers (chosen)",
    )

    @model_validator(mode="after")
    def _has_both_kinds(self) -> Self:
        check_areas(self.areas)
        return self


class Scenario(Part):
    """Everything that fixes a world but its seed."""

    name: str = Field("custom", min_length=1, description="Name in tables and data")
    arena: Arena = Arena()
    robot: Robot = Robot()
    sensors: Sensors = Sensors()
    radio: Radio = Radio()
    task: Task = Task()
    faults: Faults = Faults()
    tick: Positive = Field(0.1, ge=MIN_TICK, description="Control period [s]. TR 5 (published)")
    obstacles: tuple[Obstacle, ...] = Field(
        (), description="Discs and walls inside the arena [m]. Not in the papers (chosen)"
    )

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        check_room(self)
        self.faults.check_robots(self.task.n_robots)
        check_duration(self.task.duration, self.tick)
        return self

    @property
    def n_ticks(self) -> int:
        """Ticks in an episode."""
        return round(self.task.duration / self.tick)

    @property
    def falsifying(self) -> tuple[str, ...]:
        """What in it changes the messages of robots, by dotted name."""
        return self.faults.falsifying

    @property
    def slots(self) -> int:
        """Messages that a robot can hear in a tick: at most one of each other robot."""
        return min(self.radio.slots, max(1, self.task.n_robots - 1))

    @property
    def places(self) -> tuple[Area, ...]:
        """All areas, the first nest and the first prey area in front."""
        if self.task.areas:
            return in_order(self.task.areas)
        half = 0.5 * self.task.area_distance
        return Area(kind="nest", centre=(-half, 0.0)), Area(kind="prey", centre=(half, 0.0))

    @property
    def areas(self) -> Float64[Array, "areas 2"]:
        """Centres of the first nest and the first prey area at the start, world frame [m]."""
        return np.array([area.centre for area in self.places[:2]])
