"""What is recorded: worlds under every controller, and environments under every layer to learn."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

from tests.golden import readout
from tests.golden.readout import Readout

Take = Callable[[Readout], None]
Results = dict[str, list[int]]

SEEDS = (0, 1)
ENGINES = ("rigid", "kinematic")
MINUTE = {"task.duration": 60.0}
"""600 ticks; ticks on the path are counted in the second half of them."""

TICKS = 600
WAYPOINT_TICKS = 200
STEPS = 200
BUSY_STEPS = 1000

BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.02}
"""Fast robots and near areas: round trips and exchanges within a minute."""

ARENAS: dict[str, tuple[str, Mapping[str, Any]]] = {
    **{name: (name, MINUTE) for name in ("es1", "real", "ants2008", "es2", "es3")},
    "es1-busy": ("es1", {**MINUTE, **BUSY}),
}
FAULTY: dict[str, Any] = {
    **{f"faults.{kind}.share": 0.2 for kind in ("worn", "deaf", "mute", "blind", "liar", "stale")},
    "faults.dead.robots": (3,),
    "faults.dead.at": 20.0,
    "faults.liar.conspire": "turn",
}
"""Robots with faults of every kind."""

NEAR_PREY = {"kind": "prey", "centre": (0.35, 0.0), "moves_at": 30.0, "moves_to": (0.0, 0.4)}
AREAS: dict[str, Any] = {
    "task.start_radius": 0.2,
    "task.areas": ({"kind": "nest", "centre": (-0.35, 0.0)}, NEAR_PREY, {"centre": (0.9, 0.6)}),
}
"""Areas of which one moves in mid-episode."""

WORLDS: dict[str, tuple[str, Mapping[str, Any]]] = {
    "es1-faulty": ("es1", {**MINUTE, "robot.cruise_speed": 0.12, **FAULTY}),
    "mg1-square": ("mg1-square", {**MINUTE, "robot.cruise_speed": 0.12}),
    "mg1-dodecagon-shadowed": ("mg1-dodecagon", {**MINUTE, "radio.is_shadowed": True}),
    "two-prey-moving": ("two-prey", {**MINUTE, "robot.cruise_speed": 0.12, **AREAS}),
}
"""Worlds with faults, obstacles, and more areas than two."""
FIELDS = ("waypoints-05", "waypoints-25", "waypoints-05-authors", "waypoints-25-authors")
ESTIMATORS = ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
LAYERS = ("weighting", "motion", "both", "everything")


@dataclass(frozen=True)
class Case:
    """Something that runs tick by tick, or step by step."""

    name: str
    kind: str
    length: int
    play: Callable[[int, Take], Results] = field(repr=False)
    """Hands over the readouts after the reset and after each of so many ticks; what it came to."""


def all_cases() -> dict[str, Case]:
    """Every case by name."""
    cases = [*arena_cases(), *world_cases(), *field_cases(), *environment_cases()]
    return {case.name: case for case in cases}


def arena_cases() -> Iterator[Case]:
    """Robots that forage: every controller in every arena, under both engines."""
    by_estimator = [f"subsumption:estimator={each}" for each in (*ESTIMATORS, "social_odometry")]
    for arena, (scenario, overrides) in ARENAS.items():
        more = by_estimator if scenario == "es1" else []
        for controller in (*readout.controllers_of(scenario), *more):
            for engine in ENGINES:
                play = partial(_ticks, scenario, controller, engine, overrides)
                yield Case(f"{arena}/{engine}/{controller}", "foraging", TICKS, play)


def world_cases() -> Iterator[Case]:
    """What no arena of the papers has: faults, obstacles, and areas that move."""
    for name, (scenario, overrides) in WORLDS.items():
        for controller in ("ssgikf", "dsgiff-penalised", "ssgikf-sceptical", "learned-both"):
            for engine in ENGINES:
                play = partial(_ticks, scenario, controller, engine, overrides)
                yield Case(f"{name}/{engine}/{controller}", "foraging", TICKS, play)


def field_cases() -> Iterator[Case]:
    """Robots that visit waypoints: every controller, every estimator in both settings."""
    chosen = [
        f"boids-adaptive:estimator={estimator},setting={setting}"
        for estimator in ESTIMATORS
        for setting in ("corrected", "authors")
    ]
    for scenario in FIELDS:
        usual = readout.controllers_of(scenario)
        authors = [f"{each}:setting=authors" for each in usual if scenario.endswith("authors")]
        for controller in (*usual, *authors, *chosen):
            play = partial(_ticks, scenario, controller, None, {})
            yield Case(f"{scenario}/{controller}", "waypoints", WAYPOINT_TICKS, play)


def environment_cases() -> Iterator[Case]:
    """Environments: every layer to learn under its terms, and controllers beside it."""
    for engine, numbers in product(({"physics": engine} for engine in ENGINES), ({}, BUSY)):
        for options in (*_terms(), *_residual(), *(_worlds() if numbers else ())):
            yield _environment("parallel", "es1", options | engine | numbers)
        for options in _alone():
            yield _environment("learner", "es1", options | engine | numbers)
    for options in _base_controllers():
        yield _environment("parallel", "es1", options | {"physics": "kinematic"} | BUSY)
    for options in _terms():
        yield _environment("parallel", "waypoints-05", options)
    for options in _alone():
        yield _environment("learner", "waypoints-05", options)


def _terms() -> Iterator[dict[str, Any]]:
    """Each layer under each reward, with and without shaping, and one held action."""
    for learn in LAYERS:
        for reward in ("own", "team"):
            for shaping in (0.0, 1.0):
                yield {"learn": learn, "reward": reward, "shaping": shaping}
    yield {"learn": "both", "shaping": 1.0, "decision_period": 5}


def _residual() -> Iterator[dict[str, Any]]:
    """Wheels added to those of the hand-written motion."""
    yield {"learn": "motion", "residual": True}
    yield {"learn": "both", "residual": True}
    yield {"learn": "both", "residual": True, "decision_period": 5}


def _alone() -> Iterator[dict[str, Any]]:
    """A single learner."""
    for learn in ("motion", "weighting"):
        for reward in ("own", "team"):
            yield {"learn": learn, "reward": reward}


def _base_controllers() -> Iterator[dict[str, Any]]:
    """Controllers other than the usual one beside the layer to learn."""
    for controller in ("dsgiff-frequent", "sikf", "covariance", "boids-adaptive"):
        for learn in ("weighting", "motion", "both"):
            yield {"learn": learn, "controller": controller}


def _worlds() -> Iterator[dict[str, Any]]:
    """Mixed swarms, of several teams and groups, and numbers drawn anew for each episode."""
    mixed = ["ssgikf", "ssgikf", "ssgiff", "dsgikf", "nc", "learned-motion", "covariance"]
    drawn = {"sensors.wheel_noise": (0.0, 0.2), "radio.max_range": (0.1, 0.3)}
    for learn in ("weighting", "motion"):
        yield {"learn": learn, "controller": [*mixed, *["ssgikf"] * 3], "learners": [0, 2, 9]}
        yield {"learn": learn, "randomise": drawn}
    yield {"learn": "everything", "learners": [0, 4, 5]}


def _environment(kind: str, scenario: str, options: dict[str, Any]) -> Case:
    """An episode from the seed, and some decisions of the next, which begins without one."""
    is_busy = options.items() >= BUSY.items()
    is_short = scenario in FIELDS and "decision_period" in options
    length = BUSY_STEPS if is_busy else STEPS
    cycles = 40 if is_short else length - 50
    text = ",".join(f"{name}={value}" for name, value in options.items() if name not in BUSY)
    name = f"{kind}/{scenario}{'-busy' if is_busy else ''}/{text}"
    play = partial(_steps, kind, scenario, {**options, "max_cycles": cycles})
    return Case(name, "environments", length, play)


def _ticks(
    scenario: str, controller: str, physics: str | None, overrides: Mapping[str, Any],
    n_ticks: int, take: Take,
) -> Results:  # fmt: skip
    """A block of worlds for so many ticks."""
    loop = readout.start(scenario, controller, SEEDS, physics, overrides)
    take(readout.readout(loop))
    for _ in range(n_ticks):
        loop.step()
        take(readout.readout(loop))
    return readout.results(loop)


def _steps(
    kind: str, scenario: str, options: Mapping[str, Any], n_steps: int, take: Take
) -> Results:
    """An environment for so many steps, of which those after the end of an episode reset it."""
    environment = readout.Environment(kind, scenario, options, SEEDS[0])
    take(environment.reset())
    for _ in range(n_steps):
        take(environment.reset() if environment.is_over else environment.step())
    return {}
