"""The differential drive: wheels to motion. dU_r, dU_l: path of the right and left wheel [m]."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.geometry import wrap


@kernel
def wheels_to_arc(dU_l: float, dU_r: float, axle: float) -> tuple[float, float]:
    """Distance of the midpoint [m] and turn [rad] for the paths of the two wheels [m].

        drho   = (dU_r + dU_l) / 2
        dtheta = (dU_r - dU_l) / b

    b = axle [m].

    Source: TR, Eq. 3 and 4.
    """
    return 0.5 * (dU_r + dU_l), (dU_r - dU_l) / axle


@kernel
def drive_to_wheels(speed: float, turn: float, sharpest_turn: float) -> tuple[float, float]:
    """Left and right wheel for a speed ahead and a turn, as shares of the cruise speed.

        a = (speed + 1) / 2,  t = s turn
        wheels = (a - t, a + t) / max(1, |a| + |t|)

    speed and turn in [-1, 1]: -1 stands and 1 is the cruise speed, 1 turns left; s = sharpest_turn
    is the sharpest turn, as a share of the largest difference between the wheels.

    >>> drive_to_wheels(0.0, 0.0, 0.3)
    (0.5, 0.5)
    """
    a, t = 0.5 * (speed + 1.0), sharpest_turn * turn
    most = max(1.0, abs(a) + abs(t))
    return (a - t) / most, (a + t) / most


@kernel
def advance(
    x: float, y: float, theta: float, drho: float, dtheta: float
) -> tuple[float, float, float]:
    """The pose after a step, the arc replaced by its chord: x, y [m], theta [rad].

        x     += drho cos(theta + dtheta / 2)
        y     += drho sin(theta + dtheta / 2)
        theta += dtheta

    Source: TR, Eq. 7; ANTS, Eq. 1.
    """
    c, s = cos_sin(theta + 0.5 * dtheta)
    return x + drho * c, y + drho * s, wrap(theta + dtheta)


@kernel
def path_length(drho: float, dtheta: float, axle: float) -> float:
    """How far the wheels went [m]: a turn on the spot counts too.

        dd = |drho| + |dtheta| b / 2

    Source: Gutierrez2010, footnote 4 (Neural Computing and Applications), for the turn.
    """
    return abs(drho) + 0.5 * abs(dtheta) * axle
