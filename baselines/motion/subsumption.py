"""Subsumption motion: talk, avoid, forage, wander; the first layer that wants something gets it.

Gutierrez et al. 2009 (TR), Section 5.

Not in the paper, and chosen here:
- communicating comes first: "the communication layer takes control of the motors' output";
- avoidance is tangential and keeps right (`tangential`): with the published "opposite to the
  vector" (`literal`) robots jam head-on on the path;
- the random walk: straight runs of exponential length, then a turn to a uniform direction;
- the steering: forward share cos(angle), turning share proportional to the angle.
"""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, UInt64
from swarm_forage_env.interface import Situation
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import wrap
from swarm_forage_env.kernels.proximity import PROXIMITY_ANGLES, response
from swarm_forage_env.kernels.rng import exponential, symmetric
from swarm_forage_env.scenario import NotNegative, Part, Positive, Scenario, Share, record
from swarm_forage_env.streams import Cause, streams

FULL_TURN_AT = 0.5
"""Off course by this angle or more, the wheels turn as fast as they can [rad] (chosen)."""

HOLD, TURN, RUN = 0, 1, 2
"""Columns of a robot's memory: ticks to hold a course after avoiding, angle still to turn to
it [rad], path left of the straight run [m]."""


@MOTIONS.register("subsumption")
class SubsumptionParameters(Part):
    """What the papers leave open about avoiding, and about the random walk."""

    avoidance: Literal["tangential", "literal"] = Field(
        "tangential", description="Around the obstacle, or opposite to it as TR 5.1 says"
    )
    gap: Positive = Field(
        0.011, le=0.05, description="Obstacles nearer than this are avoided [m] (derived)"
    )
    sector: Positive = Field(
        math.radians(100.0),
        le=math.pi,
        description="Obstacles farther than this off the heading are let be [rad] (derived)",
    )
    swerve: Positive = Field(
        math.radians(100.0),
        le=math.pi,
        description="New course, measured from the obstacle's bearing [rad] (derived)",
    )
    hold: NotNegative = Field(0.0, description="The new course is held for this long [s] (derived)")
    creep: Share = Field(
        0.15, description="Least forward share of the speed while avoiding (derived)"
    )
    mean_run: Positive = Field(
        0.33, description="Mean straight run of the random walk [m] (derived)"
    )

    def start(self, scenario: Scenario, seeds: Sequence[int]) -> "Subsumption":
        """The running motion of a block of worlds, one for each seed."""
        return Subsumption(self, scenario, seeds)


@kernel
def steer(angle: float, creep: float) -> tuple[float, float]:
    """Left and right wheel, in [-1, 1], towards a direction of the body frame [rad].

    forward = max(cos angle, creep),  turn = angle / FULL_TURN_AT in [-1, 1]
    left, right = forward -+ turn, scaled so that the faster wheel is at most 1
    """
    forward = max(math.cos(angle), creep)
    turn = min(max(angle / FULL_TURN_AT, -1.0), 1.0)
    scale = max(1.0, forward + abs(turn))
    return (forward - turn) / scale, (forward + turn) / scale


@kernel
def obstacle(proximity: Float32[Array, "8"], threshold: float, sector: float) -> tuple[bool, float]:
    """Whether something is in the way, and its bearing in the body frame [rad].

    The bearing is that of the vector sum of the sensors above the threshold within the sector.

    Source: TR, Section 5.1 (avoid).
    """
    x, y = 0.0, 0.0
    for k in range(8):
        angle = PROXIMITY_ANGLES[k]
        if proximity[k] > threshold and abs(angle) <= sector:
            x += proximity[k] * math.cos(angle)
            y += proximity[k] * math.sin(angle)
    if x == 0.0 and y == 0.0:
        return False, 0.0
    return True, math.atan2(y, x)


@kernel
def way_round(bearing: float, swerve: float) -> float:
    """The course past an obstacle, body frame [rad]: keep right, unless it is clearly there."""
    on_the_right = bearing < -math.pi / 6.0
    return wrap(bearing + swerve) if on_the_right else wrap(bearing - swerve)


@kernel
def subsume(  # noqa: PLR0913 inputs first, then what is remembered, then the output
    proximity: Float32[Array, "rows 8"],
    target: Float32[Array, "rows 2"],
    goal: Int8[Array, " rows"],
    talking: Bool[Array, " rows"],
    parameters: Array,
    memory: Float64[Array, "rows 3"],
    streams: UInt64[Array, " rows"],
    out_wheels: Float32[Array, "rows 2"],
) -> None:
    """One tick of all behaviours: communicate-stop, avoid, forage, wander, in this order."""
    turn_per_tick = parameters[0]["turn_per_tick"]
    for i in range(proximity.shape[0]):
        if talking[i]:
            out_wheels[i, :] = 0.0
            continue
        seen, bearing = obstacle(proximity[i], parameters[0]["threshold"], parameters[0]["sector"])
        creep = 0.0
        if seen:
            literal = parameters[0]["literal"] > 0.0
            turn = (
                wrap(bearing + math.pi) if literal else way_round(bearing, parameters[0]["swerve"])
            )
            memory[i, TURN] = turn
            memory[i, HOLD] = parameters[0]["hold_ticks"]
        if seen or memory[i, HOLD] > 0.0:
            memory[i, HOLD] -= 1.0
            angle, creep = memory[i, TURN], parameters[0]["creep"]
        elif goal[i] >= 0:
            angle = math.atan2(target[i, 1], target[i, 0])
        else:
            if memory[i, RUN] <= 0.0:
                memory[i, RUN] = exponential(streams, i, parameters[0]["mean_run"])
                memory[i, TURN] = math.pi * symmetric(streams, i)
            memory[i, RUN] -= parameters[0]["path_per_tick"]
            angle = memory[i, TURN]
        left, right = steer(angle, creep)
        memory[i, TURN] = wrap(memory[i, TURN] - 0.5 * (right - left) * turn_per_tick)
        out_wheels[i, 0], out_wheels[i, 1] = left, right


class Subsumption:
    """The motion of all robots of a block of worlds."""

    def __init__(
        self, parameters: SubsumptionParameters, scenario: Scenario, seeds: Sequence[int]
    ) -> None:
        """Robots about to start a random walk."""
        self._n_robots = scenario.task.n_robots
        rows = len(seeds) * self._n_robots
        self._memory: Float64[Array, "rows 3"] = np.zeros((rows, 3))
        self._streams = streams(seeds, self._n_robots, Cause.WANDER)
        self._record = _record(parameters, scenario)

    def __call__(self, situation: Situation) -> Float32[Array, "rows 2"]:
        """Left and right wheel of every robot, in [-1, 1] of the cruise speed."""
        return self.towards(situation, situation.target)

    def towards(
        self, situation: Situation, target: Float32[Array, "rows 2"]
    ) -> Float32[Array, "rows 2"]:
        """The same, where those with a goal go to another place, body frame [m]."""
        wheels = np.empty((len(situation.goal), 2), np.float32)
        subsume(
            situation.proximity,
            target,
            situation.goal,
            situation.talking,
            self._record,
            self._memory,
            self._streams,
            wheels,
        )
        return wheels

    def reset(self, world: int, seed: int) -> None:
        """Forget one world's courses, and walk at random from this seed from now on."""
        rows = slice(world * self._n_robots, (world + 1) * self._n_robots)
        self._memory[rows] = 0.0
        self._streams[rows] = streams([seed], self._n_robots, Cause.WANDER)


def _record(parameters: SubsumptionParameters, scenario: Scenario) -> Array:
    """The parameters as the kernel reads them, in ticks and sensor readings."""
    cruise, dt = scenario.robot.cruise_speed, scenario.tick
    return record(
        literal=parameters.avoidance == "literal",
        threshold=response(parameters.gap),
        sector=parameters.sector,
        swerve=parameters.swerve,
        hold_ticks=round(parameters.hold / dt),
        creep=parameters.creep,
        mean_run=parameters.mean_run,
        path_per_tick=cruise * dt,
        turn_per_tick=2.0 * cruise * dt / scenario.robot.axle,
    )
