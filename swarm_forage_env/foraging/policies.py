"""Policies in the foraging world: what each `learn=` observes, gives and replaces."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind
from swarm_forage_env.equations.differential_drive import drive_to_wheels
from swarm_forage_env.foraging.observations import (
    AREAS,
    SPEED,
    WHEELS,
    WORDS,
    encounter_features,
    heard_features,
    reading_features,
    situation_features,
)
from swarm_forage_env.foraging.policy_functions import (
    put_everything,
    put_weights,
    put_weights_and_wheels,
    put_wheels,
    show_both,
    show_exchange,
    show_readings,
    show_situation,
    write_all,
)
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.views import MotionInput, WeightingInput
from swarm_forage_env.interface import Kernel
from swarm_forage_env.policy_interface import (
    Groups,
    Index,
    PolicyInterface,
    PolicyOnGrid,
    Steering,
)
from swarm_forage_env.spaces import Feature, Layout

G = tuple(Feature(f"g.{area}", "weight", 0.0, 1.0) for area in AREAS)
"""The weight of what was heard about each area; of no effect where no exchange just ended."""

SPEEDS = tuple(Feature(f"wheels.{side}", "of cruise speed", *SPEED) for side in WHEELS)

SPEAK = Feature("speak", "broadcast if > 0", *SPEED)

SAID = tuple(Feature(f"words.{word}", "as sent", *SPEED) for word in range(WORDS))


def _weigh(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    world.robots["action"]["weight"][:, learners] = action


def _move(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    world.robots["action"]["wheels"][:, learners] = action


def _do_both(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    _weigh(world, controller, learners, action[:, :, : len(G)])
    _move(world, controller, learners, action[:, :, len(G) :])


def _do_everything(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    _move(world, controller, learners, action[:, :, :2])
    controller.minds["is_speaking"][:, learners] = action[:, :, 2] > 0.0
    controller.minds["words"][:, learners] = action[:, :, 3:]


@dataclass(frozen=True)
class Writer:
    """Writes observations by an entry point on the records of robots and minds."""

    write: Kernel

    def __call__(self, world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
        """Write the observations of all robots."""
        self.write(world.robots, controller.minds["estimator"], world.scenario.slots, out)


_write_readings = bind(write_all, {"show": show_readings})


def _observe_readings(world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
    _write_readings(world.robots, controller.minds, world.scenario.slots, out)


def _encounter(scenario: Scenario) -> Groups:
    return {"encounter": encounter_features(scenario)}


def _situation(scenario: Scenario) -> Groups:
    return {"situation": situation_features(scenario, scenario.slots)}


def _both(scenario: Scenario) -> Groups:
    return {**_encounter(scenario), **_situation(scenario)}


def _raw(scenario: Scenario) -> Groups:
    n_slots = scenario.slots
    return {"readings": reading_features(scenario), "heard": heard_features(scenario, n_slots)}


STEERINGS = {
    "drive": Steering(
        Layout(
            (
                Feature("drive.speed", "-1 stands, 1 is the cruise speed", *SPEED),
                Feature("drive.turn", "of the sharpest turn, to the left", *SPEED),
            )
        ),
        choices=((1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)),
        command=drive_to_wheels,
    ),
    "wheels": Steering(
        Layout(SPEEDS),
        choices=((1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (-1.0, 1.0), (1.0, -1.0)),
    ),
}
"""How a policy can steer, by the name that `action` takes; the first is the usual one."""

N_SYMBOLS = 4
"""Messages among which a discrete action of everything chooses, beside silence."""


def symbols() -> Float32[Array, "choices numbers"]:
    """What a robot can say in a discrete action: nothing, or one of the words alone."""
    said = np.zeros((1 + N_SYMBOLS, 1 + WORDS), np.float32)
    said[0, 0], said[1:, 0] = -1.0, 1.0
    said[1:, 1 : 1 + N_SYMBOLS] = np.eye(N_SYMBOLS)
    return said


_INPUTS = {"encounter": WeightingInput, "situation": MotionInput}

LEARNABLE = {
    "weighting": PolicyInterface(
        Layout(G),
        _encounter,
        Writer(bind(write_all, {"show": show_exchange})),
        _weigh,
        ("weighting",),
        _INPUTS,
        PolicyOnGrid(show_exchange, put_weights),
        n_weights=len(G),
    ),
    "motion": PolicyInterface(
        Layout(SPEEDS),
        _situation,
        Writer(bind(write_all, {"show": show_situation})),
        _move,
        ("motion",),
        _INPUTS,
        PolicyOnGrid(show_situation, put_wheels),
        decision_period=10,
        is_steering=True,
        target="situation.target",
    ),
    "both": PolicyInterface(
        Layout(G + SPEEDS),
        _both,
        Writer(bind(write_all, {"show": show_both})),
        _do_both,
        ("weighting", "motion"),
        _INPUTS,
        PolicyOnGrid(show_both, put_weights_and_wheels),
        n_weights=len(G),
        is_steering=True,
        target="situation.target",
    ),
    "everything": PolicyInterface(
        Layout((*SPEEDS, SPEAK, *SAID)),
        _raw,
        _observe_readings,
        _do_everything,
        (),
        {},
        PolicyOnGrid(show_readings, put_everything),
        decision_period=5,
        is_steering=True,
        said=symbols(),
    ),
}
"""What a policy can take the place of, by the name that `learn` takes."""
