"""What is kept of robots that forage, in every tick."""

from collections.abc import Mapping

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.fault_record import KINDS
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.no_layers import has_estimators
from swarm_forage_env.trajectory import TrajectoryColumn, TrajectoryKind

FAULTS = tuple(
    "+".join(kind for bit, kind in enumerate(KINDS) if number >> bit & 1)
    for number in range(1, 1 << len(KINDS))
)
"""The words of every combination of faults, by the number that they make as bits, less one."""


def take(world: ForagingWorld, minds: Array) -> Mapping[str, Array]:
    """The columns of every robot as it stands."""
    robots = world.robots
    has_beliefs = has_estimators(minds)
    situation = minds["estimator"]["situation"] if has_beliefs else Situation.array(robots.shape)
    known = situation["known"] != 0
    p = np.where(known, situation["p"], np.nan)
    bits = (robots["fault"]["active"] != 0) @ (1 << np.arange(len(KINDS)))
    return {
        "x": robots["pose"][:, :, 0],
        "y": robots["pose"][:, :, 1],
        "heading": robots["pose"][:, :, 2],
        "goal": (situation["goal"] @ [0, 1, -1]).astype(np.int8),
        "known_nest": known[:, :, 0],
        "known_prey": known[:, :, 1],
        "p_nest": p[:, :, 0],
        "p_prey": p[:, :, 1],
        "messages": robots["heard"]["n"],
        "round_trips": robots["round_trips"],
        "fault": bits - 1,
    }


FORAGING_TRAJECTORY = TrajectoryKind(
    (
        TrajectoryColumn("x", "f4", "true place along the arena [m], its centre is 0"),
        TrajectoryColumn("y", "f4", "true place across the arena [m]"),
        TrajectoryColumn("heading", "f4", "true heading [rad], -pi to pi, 0 along x"),
        TrajectoryColumn(
            "goal", "i1", "area that the robot goes to; empty: it has no goal", ("nest", "prey")
        ),
        TrajectoryColumn("known_nest", "?", "the robot believes it knows where a nest is"),
        TrajectoryColumn("known_prey", "?", "the same of a prey area"),
        TrajectoryColumn(
            "p_nest", "f4", "inverse confidence: path since the nest was seen [m]; empty: unknown"
        ),
        TrajectoryColumn("p_prey", "f4", "the same of the prey area [m]"),
        TrajectoryColumn("messages", "i4", "messages that the robot heard in this tick"),
        TrajectoryColumn("round_trips", "i4", "round trips that it has completed so far"),
        TrajectoryColumn(
            "fault", "i1", "faults in effect, as liar or deaf+mute; empty: none", FAULTS
        ),
    ),
    take,
)
