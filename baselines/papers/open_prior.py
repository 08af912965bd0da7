"""Numbers and rules that TR and ANTS leave open: their prior, and the experiments of a set.

Not in the paper: the prior, uniform or log-uniform within the physical ranges of the texts; and the
rules to choose from.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from scipy.stats import loguniform, randint, uniform

from baselines.controllers import SINGLE, SUBSUMPTION
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.papers.experiments import Experiment
from swarm_forage_env.parameters import override
from swarm_forage_env.registry import SCENARIOS

Value = float | int | str

PRIOR: Mapping[str, Any] = {
    "robot.cruise_speed": uniform(0.04, 0.04),  # at 0.129, the largest possible, too many trips
    "sensors.wheel_noise": loguniform(0.02, 0.2),  # 20 % in steps of 1 ms, and of a tick
    "radio.exchange_time": loguniform(0.1, 1.0),  # both areas, both ways; ten times that
    "radio.frames": randint(1, 11),  # ten words of 9.2 ms fit into a tick
    "radio.slots": (1, 4),  # messages heard per tick
    "estimator.refractory": uniform(0.0, 40.0),  # up to a trip of es1
    "estimator.pause": uniform(0.0, 25.0),
    "estimator.deaf_when_lost": uniform(0.0, 10.0),
    "estimator.lost_within": loguniform(0.01, 0.1),  # a tick's path; an area's radius
    "estimator.overshoot": uniform(0.0, 0.25),  # up to an area's diameter and a body's radius
    "estimator.first_hand": (True, False),
    "motion.avoidance": ("tangential", "literal"),
    "motion.gap": loguniform(0.004, 0.05),  # contact; the proximity sensors see no farther
    "motion.swerve": uniform(1.57, 0.53),  # along the obstacle; 120 degrees off it
    "motion.hold": uniform(0.0, 1.0),
    "motion.mean_run": loguniform(0.1, 3.0),
    "es1.area_distance": uniform(0.6, 0.9),  # from the start circle to the walls, as the others
    "es2.area_distance": uniform(1.2, 2.85),
    "es3.area_distance": uniform(1.2, 7.0),
    "ants2008.area_distance": uniform(1.4, 1.2),
}
"""Prior of each open number (SI units) and rule; each arena has its own `area_distance`."""


def values_of(draw: Iterable[float]) -> dict[str, Value]:
    """Return the set at a point of the unit cube, with numbers rounded to three digits."""
    values: dict[str, Value] = {}
    for (name, prior), at in zip(PRIOR.items(), draw, strict=True):
        if isinstance(prior, tuple):
            values[name] = prior[int(at * len(prior))]
        else:
            values[name] = float(f"{max(prior.ppf(at), prior.support()[0]):.3g}")
    return values | {"radio.frames": int(values["radio.frames"])}


def place_of(values: Mapping[str, Any]) -> list[float]:
    """Return the point of a set in the unit cube; discrete values are in the middle of a part."""
    return [
        (prior.index(values[name]) + 0.5) / len(prior)
        if isinstance(prior, tuple)
        else float(prior.cdf(values[name]) + prior.cdf(math.nextafter(values[name], -1.0))) / 2.0
        for name, prior in PRIOR.items()
    ]


def today() -> dict[str, Value]:
    """Return today's value of every number."""
    es1, arenas = SCENARIOS["es1"], ("es1", "es2", "es3", "ants2008")
    parts = {"robot": es1.robot, "sensors": es1.sensors, "radio": es1.radio, "estimator": SINGLE}
    parts |= {"motion": SUBSUMPTION} | {each: SCENARIOS[each].task for each in arenas}
    names = {name: name.split(".") for name in PRIOR}
    return {name: getattr(parts[part], field) for name, (part, field) in names.items()}


def configuration(
    of: Experiment, values: Mapping[str, Value], physics: str = "kinematic"
) -> ExperimentConfig:
    """Return the configuration of an experiment with the values of a set.

    `real` is es1 with exchanges that take 1.25 times as long (TR 6.2: 20 to 30 % longer).
    """
    home, base = of.scenario, named(of, physics)
    if home == "real":
        home = "es1"
        values = {**values, "radio.exchange_time": 1.25 * float(values["radio.exchange_time"])}
    layers = {k: v for k, v in values.items() if k.startswith(("estimator.", "motion."))}
    world = {k: v for k, v in values.items() if k.startswith(("robot.", "sensors.", "radio."))}
    world["task.area_distance"] = values[f"{home}.area_distance"]
    scenario = override(base.scenario, world, "scenario parameter")
    return replace(base, scenario=scenario, controller=base.controller.with_parameters(layers))


@cache
def named(of: Experiment, physics: str) -> ExperimentConfig:
    """Return the unchanged configuration of an experiment."""
    return of.configuration(physics)
