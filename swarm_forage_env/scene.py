"""What is drawn of one world: its stage, which stands still, and a scene for each tick.

Plain numbers in the world frame; no drawing library is needed to take them or to read them.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Bool, Float32, Float64, Int8, Int32

STATES = ("exploring", "to nest", "to prey", "lost", "talking")
"""What a robot is doing, in the order of the codes in `Scene.doing`."""

EXPLORING, TO_THE_NEST, TO_THE_PREY, LOST, TALKING = range(len(STATES))


@dataclass(frozen=True, slots=True)
class Outline:
    """An obstacle: a disc where it has one point, else walls from point to point."""

    points: Float64[Array, "points 2"]
    """Corners in order [m]."""
    radius: float
    """Radius of a disc; half the thickness of walls [m]."""
    is_closed: bool
    """A wall joins the last point to the first one."""


WITHIN = math.sqrt(-2.0 * math.log(0.05))
"""Standard deviations from the middle of an ellipse to its rim, so that it holds 95 % of a normal
distribution in the plane."""


@dataclass(frozen=True, slots=True)
class GoalField:
    """Where robots visit goals: a square about home, which is the origin and the one landmark."""

    side: float
    """Goals lie in a square of this side [m]."""
    tolerance: float
    """A goal is reached within this distance [m]."""
    reach: float
    """How far the lidar of a robot sees others and home [m]."""


@dataclass(frozen=True, slots=True)
class Stage:
    """What stays as it is for a whole episode."""

    scenario: str
    controller: str
    """What moves the robots, as the user named it."""
    length: float
    """Side of the arena along x [m]; its centre is the origin."""
    width: float
    """Side of the arena along y [m]."""
    areas: Float64[Array, "areas 2"]
    """True centres of the areas at the start [m]: first nest, first prey area, all others."""
    area_radius: float
    """Radius of the nest and of the prey area [m]."""
    start_radius: float
    """Robots start with their centres in a circle of this radius about the origin [m]."""
    robot_radius: float
    """Radius of a robot's body [m]."""
    n_robots: int
    tick: float
    """Time between two scenes [s]."""
    duration: float
    """Length of the episode [s]."""
    has_faults: bool = False
    """Robots may be faulty: pictures say how those are marked."""
    corners: Float64[Array, "corners 2"] = field(default_factory=lambda: np.zeros((0, 2)))
    """Corners of an outer wall inside the arena, in order [m]; none: the rectangle alone."""
    obstacles: tuple[Outline, ...] = ()
    """Obstacles inside the arena."""
    kinds: tuple[int, ...] = (NEST, PREY)
    """What each area is."""
    names: tuple[str, ...] = ("nest", "prey")
    """What each area is called."""
    moves: tuple[tuple[int, float, float, float], ...] = ()
    """Areas that move: which, when [s], and where to, x and y [m]."""
    states: tuple[str, ...] = STATES
    """What each code of `Scene.doing` is called here; empty: no robot ever does that."""
    goals: GoalField | None = None
    """Where robots visit goals; None: they do something else."""
    headings: tuple[str, str] = ("Round trips", "On path")
    """What the score of a scene and its share are called."""

    def areas_at(self, time: float) -> Float64[Array, "areas 2"]:
        """True centres of the areas at a time since the start [s]."""
        centres = self.areas.copy()
        for area, when, x, y in self.moves:
            if time >= when:
                centres[area] = x, y
        return centres

    def nearest_area(
        self, kind: int, place: Float64[Array, " 2"], time: float
    ) -> Float64[Array, " 2"]:
        """True centre of the area of a kind that is nearest to a place at that time [m]."""
        centres = self.areas_at(time)[np.array(self.kinds) == kind]
        nearest: Float64[Array, " 2"] = centres[np.hypot(*(centres - place).T).argmin()]
        return nearest


@dataclass(frozen=True, slots=True)
class Localised:
    """What robots that visit goals are about, and where they believe they are."""

    goal: Float64[Array, "robots 2"]
    """Where each robot is to go [m]."""
    believed: Float64[Array, "robots 2"]
    """Where it believes it is [m]; where it is, if nothing estimates that."""
    ellipse: Float64[Array, "robots 3"]
    """Standard deviations of its estimate along the long and short axis [m], and the direction of
    the long [rad]; zeros if nothing estimates."""
    right: Int32[Array, " robots"]
    """Goals that it has claimed so far and reached."""
    wrong: Int32[Array, " robots"]
    """Goals that it has claimed so far and not reached."""

    def is_within(self, pose: Float64[Array, "robots 3"]) -> Bool[Array, " robots"]:
        """Whether the true place of each robot lies within its ellipse, `WITHIN` wide."""
        along, across, direction = self.ellipse.T
        x, y = (pose[:, :2] - self.believed).T
        c, s = np.cos(direction), np.sin(direction)
        least = np.finfo(np.float64).tiny
        u = (c * x + s * y) / np.maximum(along, least)
        v = (c * y - s * x) / np.maximum(across, least)
        return np.asarray(np.hypot(u, v) <= WITHIN)


def without_beliefs(n: int) -> dict[str, Any]:
    """What a scene holds of n robots that believe, count and do nothing of their own."""
    return {
        "doing": np.zeros(n, np.int8),
        "believed": np.zeros((n, 2, 2)),
        "known": np.zeros((n, 2), np.bool_),
        "p": np.zeros((n, 2), np.float32),
        "round_trips": np.zeros(n, np.int32),
        "on_path": 0.0,
    }


@dataclass(frozen=True, slots=True)
class Scene:
    """One world at one tick. Arrays are copies: the next tick leaves a scene as it is."""

    time: float
    """Since the start of the episode [s]."""
    pose: Float64[Array, "robots 3"]
    """x, y [m] and heading [rad]."""
    doing: Int8[Array, " robots"]
    """What each robot is doing, as a place in STATES.

    Lost: it once reported to be lost, and has neither seen an area nor heard of one since. Where no
    hand-written estimator runs, a robot is going where the task sends it next.
    """
    believed: Float64[Array, "robots areas 2"]
    """Where each robot believes the areas to be [m]; zeros where it does not know."""
    known: Bool[Array, "robots areas"]
    """The robot believes it knows where the area is."""
    p: Float32[Array, "robots areas"]
    """Inverse confidence: path travelled since the area was seen [m]; zeros where unknown."""
    messages: Int32[Array, "messages ends"]
    """Sender and receiver of every message heard in this tick."""
    round_trips: Int32[Array, " robots"]
    """Completed trips nest -> prey -> nest of each robot so far."""
    on_path: float
    """Share of the robots that is on the path now, as `metrics.knows_both_areas_share` says."""
    faulty: Bool[Array, " robots"] | None = None
    """A fault of the robot is in effect; None where no robot can be faulty."""
    localised: Localised | None = None
    """Goals, estimates and claims; None where robots forage."""

    @property
    def total(self) -> int:
        """The score: round trips of all robots, or goals that they have reached."""
        if self.localised is not None:
            return int(self.localised.right.sum())
        return int(self.round_trips.sum())

    @property
    def share(self) -> float:
        """Share of the robots that is on the path, or whose true place lies in its ellipse."""
        if self.localised is not None:
            return float(self.localised.is_within(self.pose).mean())
        return self.on_path
