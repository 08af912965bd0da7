"""Scenarios of the waypoints task: all parameters of the world of adaptive boids.

Robots visit random goals, with home, the origin, as the only landmark; there are no walls and no
contacts. The origin of a parameter is: published (in the paper), code (in the authors' code,
which made the paper's figures) or chosen. BOIDS is Smith et al. 2021.

Not in the paper, and taken from the authors' code:
- robots start within 1 m of home, at full speed, and turn before they go;
- a tick of 0.5 s, and the limits of speed, turn rate and acceleration;
- the turn rate is the angle to the new course, a second;
- robots steer by their true heading (`compass`); only the estimate of the pose uses the gyro;
- the fix at home includes the heading, with the deviation that the paper gives in metres;
- robots hit neither walls nor each other;
- first goals lie in one quarter of the square.
"""

from typing import TYPE_CHECKING, Self

from pydantic import Field, model_validator

from swarm_forage_env.parameters import (
    MIN_TICK,
    BaseScenario,
    BaseTask,
    Count,
    NotNegative,
    Parameters,
    Positive,
    Share,
)

if TYPE_CHECKING:
    from swarm_forage_env.waypoints.episode import WaypointEpisode


class CreateRobot(Parameters):
    """The robot: an iRobot Create with limits of speed, turn rate and acceleration."""

    max_speed: Positive = Field(0.5, description="Highest speed [m/s] (code)")
    min_speed: NotNegative = Field(0.01, description="Lowest speed: it never stops [m/s] (code)")
    max_turn_rate: Positive = Field(1.0, description="Highest turn rate [rad/s] (code)")
    max_acceleration: Positive = Field(
        5.0, description="Acceleration of a full pull [m/s^2] (code)"
    )

    @model_validator(mode="after")
    def _limits_in_order(self) -> Self:
        if self.min_speed >= self.max_speed:
            raise ValueError(
                f"min_speed={self.min_speed}: must be below max_speed={self.max_speed} [m/s]"
            )
        return self


class WaypointSensors(Parameters):
    """The sensors and their noise; every error is normally distributed.

    Errors below the bounds would lead to covariances that are singular in float64.
    """

    speed_noise: Positive = Field(
        0.05, description="Standard deviation of a speed reading [m/s]. Table 2 (published)"
    )
    speed_bias: NotNegative = Field(
        0.005,
        description="Standard deviation over robots of its constant error [m/s]. Table 2"
        " (published)",
    )
    turn_noise: Positive = Field(
        0.02, description="Standard deviation of a gyro reading [rad/s]. Table 2 (published)"
    )
    turn_bias: NotNegative = Field(
        0.05,
        description="Standard deviation over robots of its constant error [rad/s]. Table 2"
        " (published)",
    )
    spread: Share = Field(
        0.01,
        description="The noise of speed and turn rate varies by +- this share over robots. Section"
        " III.2 (published)",
    )
    reach: Positive = Field(
        1.0, description="Robots and home are seen up to here [m]. Section III.2 (published)"
    )
    range_noise: Positive = Field(
        0.01, ge=1e-3, description="Standard deviation of a LiDAR range [m]. Table 2 (published)"
    )
    bearing_noise: Positive = Field(
        0.02,
        ge=1e-3,
        description="Standard deviation of a LiDAR bearing [rad]. Table 2 (published)",
    )
    home_noise: Positive = Field(
        0.001,
        ge=1e-4,
        description="Standard deviation of a fix at home, of x, y [m] and heading [rad], of which"
        " the paper gives the former. Table 2 (published)",
    )


class WaypointTask(BaseTask):
    """The task: visit random goals one after the other, and claim each on arrival."""

    n_robots: Count = Field(
        25, le=2_000, description="Robots: each pair takes about 100 bytes. Section IV (published)"
    )
    duration: Positive = Field(
        100.0, description="Length of an episode [s]. Section III.2 (published)"
    )
    tolerance: Positive = Field(
        0.2, description="A goal is reached within this distance [m]. Section IV.3 (published)"
    )
    side: Positive = Field(
        10.0,
        description="Goals lie in a square of this side about home [m]. Section III.2 (published)",
    )
    start_half_side: Positive = Field(
        1.0, description="Robots start within +- this of home, in x and y [m] (code)"
    )
    first_goal: Positive = Field(
        1.0, description="First goals have x and y from here to half the side [m] (code)"
    )
    extra_ticks: int = Field(
        0,
        ge=0,
        description="Ticks that averages over time count without their having been run (2 in the"
        " authors' code; chosen)",
    )

    @model_validator(mode="after")
    def _goals_in_the_square(self) -> Self:
        if self.first_goal >= 0.5 * self.side:
            raise ValueError(
                f"first_goal={self.first_goal}: must be below half of side={self.side} [m]"
            )
        return self


class WaypointsScenario(BaseScenario):
    """All parameters of a waypoints world; with a seed they determine it."""

    name: str = Field("custom", min_length=1, description="Name in tables and data")
    robot: CreateRobot = CreateRobot()
    sensors: WaypointSensors = WaypointSensors()
    task: WaypointTask = WaypointTask()
    tick: Positive = Field(0.5, ge=MIN_TICK, description="Control period [s] (code)")

    if TYPE_CHECKING:
        _episode: type[WaypointEpisode]
