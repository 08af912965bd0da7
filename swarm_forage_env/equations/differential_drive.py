"""The differential drive: wheels to motion. dU_r, dU_l: path of the right and left wheel [m]."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos, cos_sin
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.equations.random_draws import Streams, symmetric

FULL_TURN_AT = 0.5
"""Smallest heading error at which `wheels_towards` turns at the full rate [rad] (chosen)."""


@kernel
def wheels_to_arc(dU_l: float, dU_r: float, axle: float) -> tuple[float, float]:
    """Return the path of the midpoint [m] and the turn [rad] for the paths of the two wheels [m].

        drho   = (dU_r + dU_l) / 2
        dtheta = (dU_r - dU_l) / b

    b = axle [m].

    Source: TR, Eq. 3 and 4.
    """
    return 0.5 * (dU_r + dU_l), (dU_r - dU_l) / axle


@kernel
def wheels_of(a: float, t: float) -> tuple[float, float]:
    """Return the wheel speeds for a speed a and a turn t: (a - t, a + t) / max(1, |a| + |t|)."""
    most = max(1.0, abs(a) + abs(t))
    return (a - t) / most, (a + t) / most


@kernel
def drive_to_wheels(speed: float, turn: float, sharpest_turn: float) -> tuple[float, float]:
    """Return the left and right wheel speeds for a speed and a turn, as shares of the cruise speed.

        a = min(1, 1 + speed),  t = s turn

    speed in [-1, 1]: -1 stops, 0 or more is the cruise speed. turn in [-1, 1]: 1 turns left.
    s = sharpest_turn: sharpest turn, as a share of the largest difference between the wheels.

    >>> drive_to_wheels(0.0, 0.0, 0.3)
    (1.0, 1.0)
    """
    return wheels_of(min(1.0, 1.0 + speed), sharpest_turn * turn)


@kernel
def drive_v1_to_wheels(speed: float, turn: float, sharpest_turn: float) -> tuple[float, float]:
    """Return the wheel speeds like `drive_to_wheels`, with a = (speed + 1) / 2: 0 is half speed.

    >>> drive_v1_to_wheels(0.0, 0.0, 0.3)
    (0.5, 0.5)
    """
    return wheels_of(0.5 * (speed + 1.0), sharpest_turn * turn)


@kernel
def wheels_towards(angle: float, creep: float) -> tuple[float, float]:
    """Return the wheel speeds in [-1, 1] that drive towards a direction in the body frame [rad].

    forward = max(cos angle, creep),  turn = angle / FULL_TURN_AT in [-1, 1]
    left, right = forward -+ turn, scaled so that the faster wheel is at most 1
    """
    forward = max(cos(angle), creep)
    turn = min(max(angle / FULL_TURN_AT, -1.0), 1.0)
    scale = max(1.0, forward + abs(turn))
    return (forward - turn) / scale, (forward + turn) / scale


@kernel
def advance(
    x: float, y: float, theta: float, drho: float, dtheta: float
) -> tuple[float, float, float]:
    """Return the pose x, y [m], theta [rad] after a step, with the arc replaced by its chord.

        x     += drho cos(theta + dtheta / 2)
        y     += drho sin(theta + dtheta / 2)
        theta += dtheta

    Source: TR, Eq. 7; ANTS, Eq. 1.
    """
    c, s = cos_sin(theta + 0.5 * dtheta)
    return x + drho * c, y + drho * s, wrap(theta + dtheta)


@kernel
def path_length(drho: float, dtheta: float, axle: float) -> float:
    """Return the path length of a step [m]; a turn on the spot counts too.

        dd = |drho| + |dtheta| b / 2

    Source: Gutierrez2010, footnote 4 (Neural Computing and Applications), for the turn.
    """
    return abs(drho) + 0.5 * abs(dtheta) * axle


@kernel
def encoder(dU: float, error: float, streams: Streams, column: int) -> float:
    """Return the path of a wheel as its encoder measures it [m], for a true path dU [m].

        dU + e,  e uniform in +- error

    error is a share of the longest path of a tick [m]; a wheel at rest has no error.

    Source: ANTS, Section 4.1.
    """
    return dU + error * symmetric(streams, column) if dU != 0.0 else 0.0
