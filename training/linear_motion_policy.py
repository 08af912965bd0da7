"""A learned motion of few weights: a linear residual policy over subsumption, from a policy file.

    residual = tanh(W_k x)                            k: with a goal, or without one
    wheels   = clip(subsumption + 2 residual, -1, 1)
    run      = 10^tanh(v x) run                       of the random walk, without a goal

x are the features below; the rows of W_k give the forward and the turning component. With all
weights zero, the motion is subsumption.

With few weights, CMA-ES can maximise the round trips of the whole swarm, whereas a policy gradient
on each robot's own trips may teach it to push its neighbours aside.
"""

import math
from collections.abc import Mapping

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from baselines.motion.subsumption import (
    WHERE_A_LEARNER_STEERS,
    Course,
    SubsumptionParameters,
    subsume,
)
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.control import RESIDUAL_GAIN
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.elementary import cos_sin, exp, hypot, tanh
from swarm_forage_env.equations.proximity import RAY_COS, RAY_SIN
from swarm_forage_env.foraging.inputs import goal_of
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.record import Numbers, field
from swarm_forage_env.task import task_of
from training.learned_weighting import LearnedLayer, flatten
from training.policy_file import Policy, Shapes, load_policy

FEATURES = (
    "one", "target_left", "target_ahead", "near", "unsure",
    "obstacle_left", "obstacle_ahead", "obstacle_right",
    "robot_left", "robot_ahead", "robots", "turning",
)  # fmt: skip
"""Input features. `near` falls with the distance to the goal, or without a goal with the path
travelled since there was one; `unsure` grows with the inverse confidence p, or with that path;
`robot` is the nearest sender heard, `robots` the share of message slots in use."""

N_WEIGHTS = 5 * len(FEATURES)  # number of weights of a policy

CLOSE, LONG = 0.15, 2.0
"""Distances [m] at which `near` and the closeness of a robot, and `unsure`, are one half."""

SPAN = math.log(10.0)  # largest change of the logarithm of a straight run's length


class SearchCourse(Course):
    """Course of a robot, with the memory of the policy. Writers: `steer`, `subsume`."""

    searched: float = field(np.float64, unit="m")
    """Path travelled since the robot last had a goal."""

    features: Float64[Array, " features"] = field(np.float64, len(FEATURES))
    """Input features of this tick."""


@kernel
def goal_features(
    target: Float32[Array, "2"], p: float, searched: float, out_x: Float64[Array, " features"]
) -> None:
    """Write direction, nearness and uncertainty of the goal; `searched` < 0 means a goal."""
    distance, unsure = searched, searched
    if searched < 0.0:
        distance, unsure = hypot(target[0], target[1]), p
        out_x[1] = target[1] / (distance + 1e-6)
        out_x[2] = target[0] / (distance + 1e-6)
    out_x[3] = CLOSE / (CLOSE + distance)
    out_x[4] = unsure / (unsure + LONG)


@kernel
def proximity_features(proximity: Float32[Array, "8"], out_x: Float64[Array, " features"]) -> None:
    """Write the features of the proximity sensors: obstacles to the left, ahead and right."""
    for k in range(8):
        side, ahead = RAY_SIN[k], RAY_COS[k]
        out_x[5] += proximity[k] * max(side, 0.0)
        out_x[6] += proximity[k] * max(ahead, 0.0)
        out_x[7] += proximity[k] * max(-side, 0.0)


@kernel
def message_features(heard: Heard, slots: float, out_x: Float64[Array, " features"]) -> None:
    """Write the features of the messages: the nearest sender, and the share of slots in use."""
    if heard.n == 0:
        return
    nearest, beam = 0, heard.range_bearing
    for slot in range(1, heard.n):
        if beam[slot, 0] < beam[nearest, 0]:
            nearest = slot
    closeness = CLOSE / (CLOSE + beam[nearest, 0])
    c, s = cos_sin(beam[nearest, 1])
    out_x[8], out_x[9] = closeness * s, closeness * c
    out_x[10] = heard.n / slots


@kernel
def policy_output(
    x: Float64[Array, " features"], numbers: Float64[Array, " numbers"], mode: int
) -> tuple[float, float, float]:
    """Return the residuals of the left and the right wheel, and the factor of a straight run.

    forward, turning = tanh(W_mode x);  left, right = forward -+ turning, in [-1, 1]
    """
    forward, turning, walk = 0.0, 0.0, 0.0
    n = x.shape[0]
    for k in range(n):
        forward += numbers[2 * mode * n + k] * x[k]
        turning += numbers[(2 * mode + 1) * n + k] * x[k]
        walk += numbers[4 * n + k] * x[k]
    forward, turning = tanh(forward), tanh(turning)
    left = min(max(forward - turning, -1.0), 1.0)
    right = min(max(forward + turning, -1.0), 1.0)
    return left, right, exp(SPAN * tanh(walk))


@kernel
def write_features(
    situation: Situation,
    readings: Readings,
    heard: Heard,
    wheels: Float32[Array, "2"],
    memory: SearchCourse,
    slots: float,
) -> None:
    """Write all input features of a tick to the memory; `wheels` are the last wheel speeds."""
    x = memory.features
    for k in range(x.shape[0]):
        x[k] = 0.0
    x[0] = 1.0
    goal = goal_of(situation.goal)
    if goal >= 0:
        goal_features(situation.target, situation.p[goal], -1.0, x)
    else:
        goal_features(situation.target, 0.0, memory.searched, x)
    proximity_features(readings.proximity, x)
    message_features(heard, slots, x)
    x[11] = 0.5 * (wheels[1] - wheels[0])


@kernel
def add_residual(wheels: Float32[Array, "2"], left: float, right: float) -> None:
    """Add the residuals to the speeds of subsumption: clip(own + RESIDUAL_GAIN residual, -1, 1)."""
    reach = np.float32(RESIDUAL_GAIN)
    wheels[0] = min(max(wheels[0] + reach * np.float32(left), -1.0), 1.0)
    wheels[1] = min(max(wheels[1] + reach * np.float32(right), -1.0), 1.0)


@kernel
def steer(
    situation: Situation,
    readings: Readings,
    heard: Heard,
    wheels: Float32[Array, "2"],
    memory: SearchCourse,
    numbers: Numbers,
) -> None:
    """Correct subsumption by the policy; `wheels` holds the last speeds, and then the next.

    A talking robot gets no residual: communication takes control of the motors (TR, Section 5.2).
    """
    has_goal = goal_of(situation.goal) >= 0
    walked = numbers.path_per_wheel * abs(np.float64(wheels[0]) + np.float64(wheels[1]))
    memory.searched = 0.0 if has_goal else memory.searched + walked
    write_features(situation, readings, heard, wheels, memory, numbers.slots)
    mode = 0 if has_goal else 1
    left, right, factor = policy_output(memory.features, numbers.policy, mode)
    run_before = memory.run
    subsume(situation, readings, situation.target, wheels, memory, numbers)
    if memory.run < run_before:
        memory.run += 2.0 * numbers.path_per_wheel * (1.0 - 1.0 / factor)
    if not situation.is_talking:
        add_residual(wheels, left, right)


class LinearMotion:
    """Architecture of learned motions."""

    name = "reflexes"  # name on a policy card

    def shapes(self, sizes: Mapping[str, int]) -> Shapes:
        """Return the shapes of the arrays of a policy, in the order of the flat weights."""
        return {
            "steer.weight": (2, 2, len(FEATURES)),  # with and without a goal; forward and turning
            "walk.weight": (len(FEATURES),),
        }

    def layer(self, policy: Array, scenario: Scenario) -> MotionLayer:
        """Return the motion layer of flat weights, which are rounded to single precision."""
        numbers = {
            **SubsumptionParameters().numbers(scenario),
            "policy": np.asarray(policy, np.float32).astype(np.float64),
            "slots": scenario.radio.slots,
            "path_per_wheel": 0.5 * scenario.robot.cruise_speed * scenario.tick,
        }
        return MotionLayer(steer, numbers, SearchCourse, kernels=WHERE_A_LEARNER_STEERS)

    def numbers_of(self, policy: Policy) -> Float64[Array, " numbers"]:
        """Return the flat weights of a policy's motion. ConfigError for another architecture."""
        shapes = self.shapes(policy.sizes_of("motion", self.name, ()))
        return flatten(policy.weights_of("motion", shapes), shapes)


LINEAR_MOTION = LinearMotion()


@MOTIONS.register("learned")
class LearnedMotion(LearnedLayer):
    """A trained policy corrects the motion. Not in the papers: all of it."""

    policy: str = Field(
        "motion", description="Weights: a bundled policy, or a file such as runs/x/best.safetensors"
    )

    def check_usable(self, scenario: object = None) -> None:
        """Raise ConfigError or UnknownNameError if the policy is missing or does not fit."""
        policy = load_policy(self.policy)
        if isinstance(scenario, Scenario) and task_of(scenario).name == "foraging":
            policy.check_fits("motion", scenario)
        LINEAR_MOTION.numbers_of(policy)

    def layer(self, scenario: Scenario) -> MotionLayer:
        """Return the compiled motion. ConfigError if the policy does not fit."""
        policy = load_policy(self.policy)
        policy.check_fits("motion", scenario)
        return LINEAR_MOTION.layer(LINEAR_MOTION.numbers_of(policy), scenario)
