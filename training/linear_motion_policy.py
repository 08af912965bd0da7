"""A learned motion of few weights: a linear residual policy over subsumption.

    residual = tanh(W_k x)                            k: with a goal, or without one
    wheels   = clip(subsumption + 2 residual, -1, 1)
    run      = 10^tanh(v x) run                       of the random walk, without a goal

x are the features below; the rows of W_k give the forward and the turning component. With all
weights zero it is subsumption.

So few weights can be optimised by CMA-ES for the round trips of the whole swarm, whereas a policy
gradient on each robot's own trips may teach it to push its neighbours aside.
"""

import math
from collections.abc import Sequence

import numpy as np

from baselines.motion.subsumption import RUN, Subsumption, SubsumptionParameters
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int64
from swarm_forage_env.envs.cuts import corrected
from swarm_forage_env.interface import Situation
from swarm_forage_env.compiler import kernel
from swarm_forage_env.kernels.proximity import PROXIMITY_ANGLES
from swarm_forage_env.scenario import Scenario
from training.learned_weighting import flatten
from training.policy_file import Policy, Shapes

NETWORK = "reflexes"
"""Name of this architecture on a policy card."""

FEATURES = (
    "one", "target_left", "target_ahead", "near", "unsure",
    "obstacle_left", "obstacle_ahead", "obstacle_right",
    "robot_left", "robot_ahead", "robots", "turning",
)  # fmt: skip
"""Input features. `near` falls with the distance to the goal, or without a goal with the path
travelled since there was one; `unsure` grows with the inverse confidence p, or with that path;
`robot` is the nearest sender heard, `robots` the share of message slots in use."""

SHAPES: Shapes = {
    "steer.weight": (2, 2, len(FEATURES)),  # with and without a goal; forward and turning
    "walk.weight": (len(FEATURES),),
}
"""Shapes of the arrays of a policy."""

N_WEIGHTS = 5 * len(FEATURES)
"""Number of weights of a policy."""

CLOSE, LONG = 0.15, 2.0
"""Distances [m] at which `near` and the closeness of a robot, and `unsure`, are one half."""

SPAN = math.log(10.0)
"""Largest change of the logarithm of a straight run's length."""


@kernel
def goal_features(
    target: Float32[Array, "2"], p: float, searched: float, out_x: Float64[Array, " features"]
) -> None:
    """Features of the goal: direction, nearness, uncertainty; `searched` < 0 means a goal."""
    distance, unsure = searched, searched
    if searched < 0.0:
        distance, unsure = math.hypot(target[0], target[1]), p
        out_x[1] = target[1] / (distance + 1e-6)
        out_x[2] = target[0] / (distance + 1e-6)
    out_x[3] = CLOSE / (CLOSE + distance)
    out_x[4] = unsure / (unsure + LONG)


@kernel
def proximity_features(proximity: Float32[Array, "8"], out_x: Float64[Array, " features"]) -> None:
    """Features of the proximity sensors: obstacles to the left, ahead and to the right."""
    for k in range(8):
        side, ahead = math.sin(PROXIMITY_ANGLES[k]), math.cos(PROXIMITY_ANGLES[k])
        out_x[5] += proximity[k] * max(side, 0.0)
        out_x[6] += proximity[k] * max(ahead, 0.0)
        out_x[7] += proximity[k] * max(-side, 0.0)


@kernel
def message_features(
    heard: Bool[Array, " slots"],
    beam: Float32[Array, "slots beam"],
    out_x: Float64[Array, " features"],
) -> None:
    """Features of the messages heard: the nearest sender, and the share of slots in use."""
    nearest, messages = -1, 0
    for slot in range(heard.shape[0]):
        if heard[slot]:
            messages += 1
            if nearest < 0 or beam[slot, 0] < beam[nearest, 0]:
                nearest = slot
    if nearest >= 0:
        closeness = CLOSE / (CLOSE + beam[nearest, 0])
        out_x[8] = closeness * math.sin(beam[nearest, 1])
        out_x[9] = closeness * math.cos(beam[nearest, 1])
        out_x[10] = messages / heard.shape[0]


@kernel
def policy_output(
    x: Float64[Array, " features"], numbers: Float64[Array, " numbers"], mode: int
) -> tuple[float, float, float]:
    """Output of the policy: residual of the left and right wheel, factor of a straight run.

    forward, turning = tanh(W_mode x);  left, right = forward -+ turning, in [-1, 1]
    """
    forward, turning, walk = 0.0, 0.0, 0.0
    n = x.shape[0]
    for k in range(n):
        forward += numbers[2 * mode * n + k] * x[k]
        turning += numbers[(2 * mode + 1) * n + k] * x[k]
        walk += numbers[4 * n + k] * x[k]
    forward, turning = math.tanh(forward), math.tanh(turning)
    left = min(max(forward - turning, -1.0), 1.0)
    right = min(max(forward + turning, -1.0), 1.0)
    return left, right, math.exp(SPAN * math.tanh(walk))


@kernel
def linear_policy(  # noqa: PLR0913 inputs first, then the outputs
    proximity: Float32[Array, "rows 8"],
    target: Float32[Array, "rows 2"],
    p: Float32[Array, "rows areas"],
    goal: Int8[Array, " rows"],
    heard: Bool[Array, "rows slots"],
    beam: Float32[Array, "rows slots beam"],
    wheels: Float32[Array, "rows 2"],
    searched: Float64[Array, " rows"],
    which: Int64[Array, " rows"],
    numbers: Float64[Array, "candidates numbers"],
    out_residual: Float32[Array, "rows 2"],
    out_factor: Float64[Array, " rows"],
) -> None:
    """Evaluate the policy of every robot: wheel residuals, and the factor of its straight runs."""
    x = np.zeros(len(FEATURES))
    for i in range(proximity.shape[0]):
        x[:] = 0.0
        x[0] = 1.0
        has_goal = goal[i] >= 0
        goal_features(
            target[i],
            float(p[i, goal[i]]) if has_goal else 0.0,
            -1.0 if has_goal else searched[i],
            x,
        )
        proximity_features(proximity[i], x)
        message_features(heard[i], beam[i], x)
        x[11] = 0.5 * (wheels[i, 1] - wheels[i, 0])
        left, right, factor = policy_output(x, numbers[which[i]], 0 if has_goal else 1)
        out_residual[i, 0], out_residual[i, 1] = left, right
        out_factor[i] = factor


class LinearMotionPolicy(Subsumption):
    """The running motion: subsumption plus a linear policy, or one candidate for each world."""

    def __init__(
        self,
        numbers: Array,
        scenario: Scenario,
        seeds: Sequence[int],
        of_row: Int64[Array, " rows"] | None = None,
    ) -> None:
        """Take flat weights, a row per candidate, and each robot's candidate (None: the first)."""
        super().__init__(SubsumptionParameters(), scenario, seeds)
        rows = len(seeds) * self._n_robots
        self._numbers = np.asarray(numbers, np.float32).astype(np.float64)
        self._of_row = np.zeros(rows, np.int64) if of_row is None else of_row
        self._path = 0.5 * scenario.robot.cruise_speed * scenario.tick
        self._searched: Float64[Array, " rows"] = np.zeros(rows)

    def __call__(self, situation: Situation) -> Float32[Array, "rows 2"]:
        """Left and right wheel speed of every robot, as a share of cruise speed in [-1, 1]."""
        s = situation
        walked = self._path * np.abs(s.wheels.sum(axis=1, dtype=np.float64))
        self._searched = np.where(s.goal >= 0, 0.0, self._searched + walked)
        residual, factor = np.empty((len(s.goal), 2), np.float32), np.empty(len(s.goal))
        linear_policy(
            s.proximity, s.target, s.p, s.goal, s.heard, s.beam, s.wheels,
            self._searched, self._of_row, self._numbers, residual, factor,
        )  # fmt: skip
        before = self._memory[:, RUN].copy()
        own = super().__call__(s)
        went = (self._memory[:, RUN] < before) & (s.goal < 0)
        self._memory[went, RUN] += 2.0 * self._path * (1.0 - 1.0 / factor[went])
        return corrected(own, residual, s.talking)

    def reset(self, world: int, seed: int) -> None:
        """Start a new episode in one world: reset its memory and reseed its random walk."""
        super().reset(world, seed)
        self._searched[world * self._n_robots : (world + 1) * self._n_robots] = 0.0


def linear_policy_of(policy: Policy) -> Float64[Array, " numbers"]:
    """Flat weights of a policy's linear motion; ConfigError if it is another architecture."""
    policy.sizes_of("motion", NETWORK, ())
    return flatten(policy.weights_of("motion", SHAPES), SHAPES)
