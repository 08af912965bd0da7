"""What the layers of robots that forage are shown, as arrays with a row for each robot."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Int8, checked
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.no_layers import estimators_of
from swarm_forage_env.record import rows


@checked
@dataclass(frozen=True, slots=True)
class WeightingInput:
    """What the weighting layer sees: one finished exchange for each row where it is valid."""

    valid: Bool[Array, " rows"]
    """An exchange ended in this tick; in other rows all else is zero, and the goal -1."""

    own_p: Float32[Array, "rows areas"]
    """Own inverse confidence: path since leaving the area [m]."""

    heard_p: Float32[Array, "rows areas"]
    """The partner's inverse confidence [m]."""

    own_known: Bool[Array, "rows areas"]
    """The robot knows where the area is."""

    heard_known: Bool[Array, "rows areas"]
    """The partner told where the area is."""

    disagreement: Float32[Array, "rows areas"]
    """Distance between the own and the heard location, where both are known [m]."""

    own_distance: Float32[Array, "rows areas"]
    """How far the robot is from the own location [m]; zero where unknown."""

    heard_distance: Float32[Array, "rows areas"]
    """How far the robot is from the heard location [m]; zero where unknown."""

    range: Float32[Array, " rows"]
    """Distance to the partner, averaged [m]."""

    frames: Float32[Array, " rows"]
    """Readings averaged in this exchange."""

    goal: Int8[Array, " rows"]
    """The area the robot is heading for: 0 nest, 1 prey, -1 none."""


@checked
@dataclass(frozen=True, slots=True)
class MotionInput:
    """What the motion layer sees."""

    proximity: Float32[Array, "rows 8"]
    """Infrared, 1 at contact and 0 beyond 5 cm, at PROXIMITY_ANGLES of the body frame."""

    ground: Float32[Array, "rows 3"]
    """Brightness under the left, middle and right ground sensor: nest 0, prey 0.5, floor 1."""

    target: Float32[Array, "rows 2"]
    """Where to go, body frame [m]; zeros without a goal."""

    areas: Float32[Array, "rows areas 2"]
    """Believed centres of nest and prey, body frame [m]; zeros where unknown."""

    p: Float32[Array, "rows areas"]
    """Own inverse confidence [m]; zeros where unknown."""

    known: Bool[Array, "rows areas"]
    """The robot believes it knows where the area is."""

    goal: Int8[Array, " rows"]
    """The area the robot is heading for: 0 nest, 1 prey, -1 none."""

    talking: Bool[Array, " rows"]
    """An exchange is under way: standing still makes its readings better."""

    heard: Bool[Array, "rows slots"]
    """The slot holds a message."""

    beam: Float32[Array, "rows slots beam"]
    """Where its sender is: range [m], bearing in the body frame [rad], and bearing of the robot
    in the body frame of the sender [rad]; zeros in an empty slot."""

    wheels: Float32[Array, "rows 2"]
    """The last command to the left and right wheel, as shares of the cruise speed."""


def exchange_of(world: ForagingWorld, minds: Array) -> WeightingInput:
    """The exchanges of all robots."""
    e = rows(estimators_of(minds)["exchange"])
    valid = e.is_valid.copy()

    def shown(column: Any, otherwise: float = 0) -> Any:  # noqa: ANN401 arrays of any kind
        mask = valid.reshape(-1, *(1,) * (column.ndim - 1))
        return np.where(mask, column, column.dtype.type(otherwise))

    return WeightingInput(
        valid=valid,
        own_p=shown(e.own_p),
        heard_p=shown(e.heard_p),
        own_known=shown(e.own_known).astype(np.bool_),
        heard_known=shown(e.heard_known).astype(np.bool_),
        disagreement=shown(e.disagreement),
        own_distance=shown(e.own_distance),
        heard_distance=shown(e.heard_distance),
        range=shown(e.range),
        frames=shown(e.n_averaged),
        goal=shown(e.goal, -1),
    )


def situation_of(world: ForagingWorld, minds: Array) -> MotionInput:
    """The situations of all robots."""
    robots, s = rows(world.robots), rows(estimators_of(minds)["situation"])
    heard, beam = received(world)
    return MotionInput(
        proximity=robots.readings.proximity.copy(),
        ground=robots.readings.ground.copy(),
        target=s.target.copy(),
        areas=s.areas.copy(),
        p=s.p.copy(),
        known=s.known.astype(np.bool_),
        goal=s.goal.copy(),
        talking=s.is_talking.copy(),
        heard=heard,
        beam=beam,
        wheels=robots.command.wheels.copy(),
    )


def received(
    world: ForagingWorld,
) -> tuple[Bool[Array, "rows slots"], Float32[Array, "rows slots 3"]]:
    """Which slots hold a message, and from where it comes; zeros in an empty slot."""
    heard = rows(world.robots).heard
    n_slots = max(scenario.slots for scenario in world.scenarios)
    valid = np.arange(n_slots) < heard.n[:, None]
    beam = np.where(valid[:, :, None], heard.range_bearing[:, :n_slots], np.float32(0.0))
    return valid, beam
