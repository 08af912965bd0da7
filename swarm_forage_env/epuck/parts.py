"""Parts of a scenario of e-pucks: arena, body, sensors, radio, and mission.

The origin of a value is one of: published (stated in a paper), derived (follows from a statement of
a paper, or fits its results), chosen (in no paper; see the description). TR is Gutierrez et al.
2009, ANTS is Gutierrez et al. 2008.

Not in the papers, and chosen here:
- the distribution of the errors of infrared, ground, range and bearing, of which the TR gives the
  size: uniform; those of infrared and ground multiply the reading;
- the error of the encoders, of which the TR tells nothing: that of ANTS 4.1, uniform and of one
  size for any speed of the wheel, none at rest;
- a sender is heard up to the range whether or not the infrared sensors see it, by which robots of
  the TR detect those with which they can communicate (TR 5);
- distances of the radio are those of the centres, and the frames that a reading averages are lost
  or heard together;
- the brightness of the grey prey area, a half.
"""

import math
from typing import Literal, Self

from pydantic import Field, field_validator, model_validator

from swarm_forage_env.epuck.obstacles import Point
from swarm_forage_env.parameters import (
    BaseTask,
    Count,
    NotNegative,
    Parameters,
    Positive,
    Share,
    list_as,
)


class Arena(Parameters):
    """Walled floor with its centre at the origin and x along the long side."""

    length: Positive = Field(1.7, description="Side along x [m]. TR Table 2 (published)")
    width: Positive = Field(1.2, description="Side along y [m]. TR Table 2 (published)")
    corners: tuple[Point, ...] = Field(
        (),
        description="Corners of an outer wall inside that rectangle, in order [m]; none: the"
        " rectangle is the outer wall. Not in the papers (chosen)",
    )

    _from_text = field_validator("corners", mode="before")(list_as("[[-1, -1], [1, -1], [0, 1]]"))

    @model_validator(mode="after")
    def _has_its_corners_inside(self) -> Self:
        if 0 < len(self.corners) < 3:
            raise ValueError(
                f"arena.corners={list(self.corners)}: a polygon has at least 3 corners"
            )
        for x, y in self.corners:
            if abs(x) > 0.5 * self.length or abs(y) > 0.5 * self.width:
                raise ValueError(
                    f"arena.corners: ({x:g}, {y:g}) lies outside the arena of {self.length:g} x"
                    f" {self.width:g} m about the origin; enlarge arena.length or arena.width"
                )
        return self


class Robot(Parameters):
    """Body of an e-puck: a disc on two wheels."""

    radius: Positive = Field(0.035, ge=1e-3, description="Body radius [m]. TR 6.1 (published)")
    axle: Positive = Field(
        0.053, ge=1e-3, description="Distance between the wheels [m]. TR 3.1 (published)"
    )
    max_speed: Positive = Field(
        0.129,
        description="Highest speed of a wheel [m/s]: 1 turn/s (TR 3.1) of a wheel of 41 mm"
        " (e-puck.org; derived)",
    )
    cruise_speed: Positive = Field(
        0.06, description="Wheel speed of a full-speed command [m/s]. Not in the papers (derived)"
    )

    @model_validator(mode="after")
    def _cruises_below_its_limit(self) -> Self:
        if self.cruise_speed > self.max_speed:
            raise ValueError(
                f"cruise_speed={self.cruise_speed}: must be at most max_speed={self.max_speed}"
                " [m/s]"
            )
        return self


class Sensors(Parameters):
    """Sensors of a robot and their noise."""

    proximity_noise: Share = Field(
        0.2, description="Infrared noise: reading x (1 +- this), uniform. TR 6.1 (published)"
    )
    ground_noise: Share = Field(
        0.3,
        description="Noise of ground sensors: reading x (1 +- this), uniform. TR 6.1 (published)",
    )
    ground_ahead: NotNegative = Field(
        0.03,
        description="Offset of ground sensors ahead of the centre [m]. ARGoS e-puck (published)",
    )
    ground_spacing: NotNegative = Field(
        0.009, description="Distance between adjacent ground sensors [m]. ARGoS e-puck (published)"
    )
    wheel_noise: Share = Field(
        0.058,
        description="Odometry error of each turning wheel in a tick: +- this share of the path"
        " at cruise speed, uniform. ANTS 4.1 gives the form; the size is derived",
    )


class Radio(Parameters):
    """Range-and-bearing radio: reception, message loss and measurement noise."""

    max_range: Positive = Field(
        0.15, description="Range of the radio, centre to centre [m]. TR 6.1 (published)"
    )
    near: NotNegative = Field(
        0.01, description="Range up to which the share loss_near is lost [m]. TR 6.1 (published)"
    )
    loss_near: Share = Field(
        0.01, description="Share of messages lost within `near`. TR 6.1 (published)"
    )
    loss_far: Share = Field(
        0.5, description="Share lost at max_range; linear in between. TR 6.1 (published)"
    )
    range_noise: NotNegative = Field(
        0.025, description="Range error of one frame: +- this, uniform [m]. TR 6.1 (published)"
    )
    bearing_noise: NotNegative = Field(
        math.radians(20.0),
        le=math.pi,
        description="Bearing error of a frame: +- this, uniform, at either end [rad]. TR 6.1"
        " (published)",
    )
    range_model: Literal["uniform", "board"] = Field(
        "uniform",
        description="Model of the range error; uniform: range_noise. board: range from the"
        " received power of the real board, lognormal (argos3-epuck). Not in the papers (chosen)",
    )
    frames: Count = Field(
        2,
        le=10_000,
        description="Number of messages averaged into one reading while the receiver stands"
        " still; one when it moves. An area takes three words of 9.2 ms (board firmware), and"
        " the partner speaks as long: nearly two fit into a tick (derived)",
    )
    slots: Count = Field(
        4,
        le=10_000,
        description="Most messages heard in a tick, drawn at random. ARGoS: up to 5 (chosen)",
    )
    exchange_time: Positive = Field(
        0.4, description="Duration of an exchange [s]. Not in the papers (derived)"
    )
    is_shadowed: bool = Field(
        False,
        description="Whether messages are lost when an obstacle lies between sender and"
        " receiver. Not in the papers (chosen)",
    )

    @property
    def is_board(self) -> bool:
        """Whether the range is computed from received power, as on the real board."""
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


class Mission(BaseTask):
    """Number of e-pucks, duration and start positions; a task adds its own parameters."""

    n_robots: Count = Field(10, description="Number of robots. TR Table 2 (published)")
    duration: Positive = Field(
        1800.0, description="Length of an episode [s]. TR Table 2 (published)"
    )
    start_radius: Positive = Field(
        0.2,
        description="Radius of the circle about the arena's centre in which the centres of the"
        " robots start [m]. TR Table 2 (published)",
    )
