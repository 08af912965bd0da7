"""The open parameters of the papers on social odometry: each one's range, and the reason for it.

One set of values holds for es1, es2 and es3; only the distance between the areas is each
arena's own. A range is what a robot or its surroundings allow, narrowed to where robots forage
at all.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from baselines.controller import LayeredController
from baselines.controllers import SINGLE, SUBSUMPTION
from baselines.evaluation.experiment_config import find_layered_controller
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.parameters import leaves
from swarm_forage_env.registry import SCENARIOS
from swarm_forage_env.scenarios import find_scenario

ARENAS = ("es1", "es2", "es3")

DIGITS = 3
"""Significant digits of a value: no more are tried than will be written down."""

STEP = 0.2
"""A parameter varied alone changes by this share of its value."""

SMALL_STEP = 0.1
"""Where that would be less than this share of the range, it changes by this share of it."""

Values = Mapping[str, float]
"""A value for each parameter, by name."""


@dataclass(frozen=True)
class ParameterRange:
    """An open parameter and the values it may take."""

    name: str
    """A part of the scenario or a layer of the controller, and its field; `es2.area_distance`
    is that of one arena."""

    low: float
    high: float
    reason: str
    """Why no less, and no more."""

    log: bool = False
    """Searched on a logarithmic scale."""

    whole: bool = False
    """A whole number."""

    def round_and_clip(self, value: float) -> float:
        """A value clipped to the range, with as many digits as are written down.

        >>> ParameterRange("robot.cruise_speed", 0.03, 0.065, "").round_and_clip(0.0412345)
        0.0412
        """
        inside = min(max(value, self.low), self.high)
        if self.whole:
            return round(inside)
        size = math.floor(math.log10(abs(inside))) + 1 if inside else 0
        return min(max(round(inside, DIGITS - size), self.low), self.high)

    def step_around(self, value: float) -> tuple[float, float]:
        """A step below and a step above a value, as far as the range goes.

        >>> ParameterRange("estimator.pause", 0.0, 25.0, "").step_around(20.0)
        (16.0, 24.0)
        """
        least = SMALL_STEP * (self.high - self.low)
        step = max(STEP * value, least, 1.0 if self.whole else 0.0)
        return self.round_and_clip(value - step), self.round_and_clip(value + step)


RANGES = (
    ParameterRange(
        "robot.cruise_speed", 0.03, 0.065,
        "[m/s] Slower makes too few trips in any arena; at 0.129, its limit, es1 would count"
        " three times the published trips, and above half of it still more than published",
    ),
    ParameterRange(
        "sensors.wheel_noise", 0.03, 0.12,
        "+-20 % of the path of a 10 ms step (ANTS 4.1) is +-6.3 % of a tick's; half to twice that",
    ),
    ParameterRange(
        "radio.exchange_time", 0.1, 1.0,
        "[s] Two areas take six frames of 9.2 ms one way, so a tick at least; a second would"
        " repeat them more than ten times",
    ),
    ParameterRange(
        "radio.frames", 1, 10,
        "One message at least; no more than 10 words of 9.2 ms fit into a tick",
        whole=True,
    ),
    ParameterRange(
        "estimator.refractory", 5.0, 40.0,
        "[s] Shorter repeats an exchange within one meeting of two robots (about 5 s in traffic);"
        " 40 s is a trip of es1",
    ),
    ParameterRange(
        "estimator.pause", 0.0, 25.0,
        "[s] None, up to about half a trip of es1: longer and hardly anybody is told of the areas",
    ),
    ParameterRange(
        "estimator.deaf_when_lost", 0.0, 10.0,
        "[s] None, or until the robot has left those who share its mistake: 0.4 m at 0.04 m/s",
    ),
    ParameterRange(
        "estimator.lost_within", 0.03, 0.08,
        "[m] A few ticks' path at least; less than the area's radius of 0.1",
    ),
    ParameterRange(
        "estimator.overshoot", 0.0, 0.25,
        "[m] None, or looking on for an area's diameter and a body's radius",
    ),
    ParameterRange(
        "motion.gap", 0.004, 0.04,
        "[m] The proximity sensors tell nothing beyond 0.04; nearer than 0.004 is contact",
    ),
    ParameterRange(
        "motion.swerve", 1.63, 2.0,
        "[rad] Below pi/2 a robot steers into the wall; above 2.0 it turns back on its way",
    ),
    ParameterRange(
        "motion.hold", 0.0, 0.8,
        "[s] None, or as long as passing a robot takes: a radius at 0.045 m/s",
    ),
    ParameterRange(
        "motion.mean_run", 0.2, 2.0,
        "[m] A few body lengths, up to the length of the smallest arena", log=True,
    ),
    ParameterRange(
        "es1.area_distance", 0.8, 1.5,
        "[m] Above 0.6 (start circle); at 1.5 both areas touch the walls",
    ),
    ParameterRange(
        "es2.area_distance", 1.25, 3.0,
        "[m] Above 1.2 (start circle); 3.0 is 2.5 times 1.2 in es1, as the arena is",
    ),
    ParameterRange(
        "es3.area_distance", 1.5, 3.5,
        "[m] Above 1.2 (start circle); the trip's period, 1.1 to 1.2 times that of es2, lets it"
        " be little farther than in es2",
    ),
)  # fmt: skip
"""Every parameter that is searched."""


def defaults() -> dict[str, float]:
    """The present default of every parameter, where a search starts."""
    found: dict[str, Any] = leaves(
        SCENARIOS["es1"].model_dump(include={"robot", "sensors", "radio"})
    )
    found |= leaves({"estimator": SINGLE.model_dump(), "motion": SUBSUMPTION.model_dump()})
    found |= {f"{arena}.area_distance": SCENARIOS[arena].task.area_distance for arena in ARENAS}
    return {each.name: found[each.name] for each in RANGES}


def rounded(values: Values) -> dict[str, float]:
    """A value for every parameter, clipped and rounded."""
    return {each.name: each.round_and_clip(values[each.name]) for each in RANGES}


def scenario_with(values: Values, arena: str, settings: Mapping[str, Any]) -> Scenario:
    """The scenario of an arena with these values and settings."""
    own = {
        name: value
        for name, value in values.items()
        if name.startswith(("robot.", "sensors.", "radio."))
    }
    distance = {"task.area_distance": values[f"{arena}.area_distance"]}
    found: Scenario = find_scenario(arena, own | distance | dict(settings))
    return found


def controller_with(values: Values, controller: str) -> LayeredController:
    """A controller (`ssgiff:beta=0.01`) with these values."""
    own = {
        name: value for name, value in values.items() if name.startswith(("estimator.", "motion."))
    }
    return find_layered_controller(controller).with_parameters(own)
