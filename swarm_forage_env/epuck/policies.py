"""Policies of e-pucks: how they steer, and what they see where there is no estimator."""

from collections.abc import Mapping

from swarm_forage_env.epuck.records import Action, Command, Heard, Readings
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.equations.differential_drive import drive_to_wheels, drive_v1_to_wheels
from swarm_forage_env.observed_fields import layout_of, paths
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.spaces import Feature, Layout

WHEELS = paths("", "robots.action", Action, "wheels")
"""What a policy of the motion gives."""


def slots(scenario: EpuckScenario) -> Mapping[str, int]:
    """How many message slots are observed in a scenario."""
    return {"slots": scenario.radio.slots}


_TURN = Feature("drive.turn", "of the sharpest turn, to the left", -1.0, 1.0)
_DRIVES = (1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)

STEERINGS = {
    "drive": Steering(
        Layout((Feature("drive.speed", "-1 stands, 0 is the cruise speed", -1.0, 1.0), _TURN)),
        choices=_DRIVES,
        command=drive_to_wheels,
    ),
    "drive-v1": Steering(
        Layout((Feature("drive.speed", "-1 stands, 1 is the cruise speed", -1.0, 1.0), _TURN)),
        choices=_DRIVES,
        command=drive_v1_to_wheels,
    ),
    "wheels": Steering(
        layout_of(WHEELS, {}, None),
        choices=((1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (-1.0, 1.0), (1.0, -1.0)),
    ),
}
"""How a policy can steer, by the name that `action` takes; the first is the usual one."""

MOTION = PolicyInterface(
    (
        *paths("readings", "robots.readings", Readings, "proximity ground"),
        *paths("heard", "robots.heard", Heard, "is_valid range_bearing"),
        *paths("command", "robots.command", Command, "wheels"),
    ),
    WHEELS,
    ("motion",),
    slots,
    decision_period=10,
    can_correct=True,
    is_steering=True,
)
"""The motion of a robot without an estimator: it sees what the sensors say, and who is near."""
