"""Records of localisation: what a robot believes of its own pose, and of the flock about it."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.record import Record, field
from swarm_forage_env.waypoints.records import Exchange, Situation

START_VARIANCE = 0.1
"""Of x, y [m^2] and heading [rad^2] at the start and, for the authors, at home (code)."""


class PoseBelief(Record):
    """An estimate of the own pose, world frame."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """x, y [m] and heading [rad]."""

    P: Float64[Array, "3 3"] = field(np.float64, 3, 3, start=START_VARIANCE * np.eye(3))
    """Its covariance."""

    velocity: Float64[Array, "2"] = field(np.float64, 2, unit="m/s")
    """Velocity of the last tick, by what was measured."""


class NeighbourMeans(Record):
    """Means and a sum over the neighbours, by what they believe. Writer: `sum_neighbours`."""

    position: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    """Mean position."""

    velocity: Float64[Array, "2"] = field(np.float64, 2, unit="m/s")
    """Mean velocity."""

    away: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    """Sum of the ways from them."""


class HomeUpdate(Record):
    """Working space of a correction by a fix at home. Writer: `correct_privately`."""

    innovation: Float64[Array, "3 3"] = field(np.float64, 3, 3)
    """P + R."""

    gain: Float64[Array, "3 3"] = field(np.float64, 3, 3)
    """K."""

    rest: Float64[Array, "3 3"] = field(np.float64, 3, 3)
    """I - K."""

    half: Float64[Array, "3 3"] = field(np.float64, 3, 3)
    """Products on the way."""


class PoseMind(Record):
    """All that dead reckoning keeps of a robot; the filters add to it."""

    belief: PoseBelief = field(PoseBelief)
    """The estimate."""

    reckoned: PoseBelief = field(PoseBelief)
    """The estimate without any neighbour: dead reckoning between visits at home."""

    compass: float = field(np.float32, unit="rad")
    """Heading without error, as read in this tick. Writer: `take_in`."""

    covariance_norm: float = field(np.float64)
    """Spectral norm of the covariance of the estimate. Writer: `take_in`."""

    neighbours: NeighbourMeans = field(NeighbourMeans)
    home: HomeUpdate = field(HomeUpdate)
    exchange: Exchange = field(Exchange)
    situation: Situation = field(Situation)
