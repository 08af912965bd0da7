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
    MAX_TICKS,
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
    min_speed: NotNegative = Field(
        0.01, description="Lowest speed: a robot never stops [m/s] (code)"
    )
    max_turn_rate: Positive = Field(1.0, description="Highest turn rate [rad/s] (code)")
    max_acceleration: Positive = Field(
        5.0, description="Highest acceleration, that of a pull of length 1 [m/s^2] (code)"
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
        description="Standard deviation over robots of the constant error of speed readings"
        " [m/s]. Table 2 (published)",
    )
    turn_noise: Positive = Field(
        0.02, description="Standard deviation of a gyro reading [rad/s]. Table 2 (published)"
    )
    turn_bias: NotNegative = Field(
        0.05,
        description="Standard deviation over robots of the constant error of gyro readings"
        " [rad/s]. Table 2 (published)",
    )
    spread: Share = Field(
        0.01,
        description="Spread of the noise of speed and turn rate over robots: +- this share. Section"
        " III.2 (published)",
    )
    reach: Positive = Field(
        1.0,
        description="Range within which robots and home are seen [m]. Section III.2 (published)",
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
        25,
        le=2_000,
        description="Number of robots; a pair takes about 100 bytes. Section IV (published)",
    )
    duration: Positive = Field(
        100.0, description="Length of an episode [s]. Section III.2 (published)"
    )
    tolerance: Positive = Field(
        0.2, description="Distance within which a goal is reached [m]. Section IV.3 (published)"
    )
    side: Positive = Field(
        10.0, description="Side of the square of goals about home [m]. Section III.2 (published)"
    )
    start_half_side: Positive = Field(
        1.0, description="Largest offset from home at which robots start, in x and in y [m] (code)"
    )
    first_goal: Positive = Field(
        1.0, description="Least x and y of first goals [m]; the largest is half the side (code)"
    )
    extra_ticks: int = Field(
        0,
        ge=0,
        le=MAX_TICKS,
        description="Number of ticks that averages over time count although they are not run"
        " (2 in the authors' code; chosen)",
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
