"""Data for drawing one world, without a drawing library: a stage, and a scene for each tick."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Bool, Float32, Float64, Int8, Int32

STATES = ("exploring", "to nest", "to prey", "lost", "talking")
"""Activities of a robot, in the order of the codes in `Scene.activity`."""

EXPLORING, TO_THE_NEST, TO_THE_PREY, LOST, TALKING = range(len(STATES))


@dataclass(frozen=True, slots=True)
class Outline:
    """An obstacle: a disc if it has one point, else walls from point to point."""

    points: Float64[Array, "points 2"]
    """Corners in order [m]."""
    radius: float
    """Radius of a disc; half the thickness of walls [m]."""
    is_closed: bool
    """Whether a wall joins the last point to the first one."""


WITHIN = math.sqrt(-2.0 * math.log(0.05))
"""Standard deviations from the centre of an ellipse to its rim, such that it contains 95 % of a
normal distribution in the plane."""


@dataclass(frozen=True, slots=True)
class GoalField:
    """Area of goals: a square around home, which is the origin and the only landmark."""

    side: float
    """Side of the square [m]."""
    tolerance: float
    """Distance within which a goal is reached [m]."""
    reach: float
    """Range within which a robot's lidar detects other robots and home [m]."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Data that stays constant for an episode."""

    scenario: str
    controller: str
    """Controller of the robots, as the user named it."""
    length: float
    """Side of the arena along x [m]; its centre is the origin."""
    width: float
    """Side of the arena along y [m]."""
    areas: Float64[Array, "areas 2"]
    """True centres of the areas at the start [m]: first nest, first prey area, then the others."""
    area_radius: float
    """Radius of the nest and of the prey area [m]."""
    start_radius: float
    """Radius of the circle around the origin in which robots start [m]."""
    robot_radius: float
    """Radius of a robot's body [m]."""
    n_robots: int
    tick: float
    """Time between two scenes [s]."""
    duration: float
    """Length of the episode [s]."""
    has_faults: bool = False
    """Whether robots may be faulty; pictures then explain how faulty robots are marked."""
    corners: Float64[Array, "corners 2"] = field(default_factory=lambda: np.zeros((0, 2)))
    """Corners of an outer wall inside the arena, in order [m]; empty: only the rectangle."""
    obstacles: tuple[Outline, ...] = ()
    """Obstacles inside the arena."""
    kinds: tuple[int, ...] = (NEST, PREY)
    """Kind of each area."""
    names: tuple[str, ...] = ("nest", "prey")
    """Name of each area."""
    moves: tuple[tuple[int, float, float, float], ...] = ()
    """Moves of areas: index of the area, time [s], new x and y [m]."""
    states: tuple[str, ...] = STATES
    """Name of each code of `Scene.activity` in this task; empty for codes that never occur."""
    believes: bool = True
    """Whether robots can have estimates of their own position or of areas."""
    goals: GoalField | None = None
    """Area of goals; None if robots visit none."""
    headings: tuple[str, str] = ("Round trips", "On path")
    """Names of the score and of the share of a scene."""

    def areas_at(self, time: float) -> Float64[Array, "areas 2"]:
        """Return the true centres of the areas [m] at a time since the start [s]."""
        centres = self.areas.copy()
        for area, when, x, y in self.moves:
            if time >= when:
                centres[area] = x, y
        return centres

    def nearest_area(
        self, kind: int, place: Float64[Array, " 2"], time: float
    ) -> Float64[Array, " 2"]:
        """Return the true centre of the area of a kind that is nearest to a place at a time [m]."""
        centres = self.areas_at(time)[np.array(self.kinds) == kind]
        nearest: Float64[Array, " 2"] = centres[np.hypot(*(centres - place).T).argmin()]
        return nearest


@dataclass(frozen=True, slots=True)
class Localised:
    """Goals and position estimates of robots that visit goals."""

    goal: Float64[Array, "robots 2"]
    """Current goal of each robot [m]."""
    believed: Float64[Array, "robots 2"]
    """Estimated position of each robot [m]; the true one if nothing estimates it."""
    ellipse: Float64[Array, "robots 3"]
    """Standard deviations of the estimate along the long and the short axis [m], and direction of
    the long axis [rad]; zeros without an estimate."""
    right: Int32[Array, " robots"]
    """Number of goals that each robot has claimed and reached so far."""
    wrong: Int32[Array, " robots"]
    """Number of goals that each robot has claimed without reaching them so far."""

    def is_within(self, pose: Float64[Array, "robots 3"]) -> Bool[Array, " robots"]:
        """Return whether the true position of each robot is inside its ellipse, `WITHIN` wide."""
        along, across, direction = self.ellipse.T
        x, y = (pose[:, :2] - self.believed).T
        c, s = np.cos(direction), np.sin(direction)
        least = np.finfo(np.float64).tiny
        u = (c * x + s * y) / np.maximum(along, least)
        v = (c * y - s * x) / np.maximum(across, least)
        return np.asarray(np.hypot(u, v) <= WITHIN)


def without_beliefs(n: int) -> dict[str, Any]:
    """Return the scene fields of n robots without beliefs, counts or activities."""
    return {
        "activity": np.zeros(n, np.int8),
        "believed": np.zeros((n, 2, 2)),
        "known": np.zeros((n, 2), np.bool_),
        "p": np.zeros((n, 2), np.float32),
        "round_trips": np.zeros(n, np.int32),
        "on_path": 0.0,
    }


@dataclass(frozen=True, slots=True)
class Scene:
    """One world at one tick. Arrays are copies: later ticks do not change a scene."""

    time: float
    """Time since the start of the episode [s]."""
    pose: Float64[Array, "robots 3"]
    """Pose of each robot: x, y [m] and heading [rad]."""
    activity: Int8[Array, " robots"]
    """Activity of each robot, as an index of STATES.

    Lost: it reported to be lost, and has neither seen an area nor received one since. Without a
    hand-written estimator, the activity is the next destination that the task prescribes.
    """
    believed: Float64[Array, "robots areas 2"]
    """Each robot's estimate of the position of each area [m]; zeros where it has none."""
    known: Bool[Array, "robots areas"]
    """Whether the robot has an estimate of the position of the area."""
    p: Float32[Array, "robots areas"]
    """Inverse confidence: path travelled since the area was seen [m]; zeros where unknown."""
    messages: Int32[Array, "messages ends"]
    """Sender and receiver of every message received in this tick."""
    round_trips: Int32[Array, " robots"]
    """Number of trips nest -> prey -> nest that each robot has completed so far."""
    on_path: float
    """Share of the robots on the path now, as in `metrics.knows_both_areas_share`."""
    faulty: Bool[Array, " robots"] | None = None
    """Whether a fault of each robot is in effect; None if no robot can be faulty."""
    localised: Localised | None = None
    """Goals, estimates and claims; None if robots visit no goals."""

    @property
    def total(self) -> int:
        """Score: round trips of all robots, or goals that they have reached."""
        if self.localised is not None:
            return int(self.localised.right.sum())
        return int(self.round_trips.sum())

    @property
    def share(self) -> float:
        """Share of robots that are on the path, or whose true position is inside their ellipse."""
        if self.localised is not None:
            return float(self.localised.is_within(self.pose).mean())
        return self.on_path
