"""Effects of faults in a tick: when they begin, and where a lie lies as the liar sees it."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import DEAD, LIAR, MUTE, N_KINDS, STALE
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.equations.random_draws import unit


@kernel
def update_faults(robot: EpuckState, world: EpuckWorldState) -> None:
    """Let the faults of a robot begin whose time has come, and see its lie from where it stands."""
    fault = robot.fault
    for kind in range(N_KINDS):
        has_begun = fault.kinds[kind] and world.ticks >= fault.starts[kind]
        fault.active[kind] = 1 if has_begun else 0
    is_gone = bool(fault.active[DEAD]) and not fault.talks_when_dead
    fault.is_silent = is_gone or bool(fault.active[MUTE])
    if fault.active[LIAR]:
        see_lie(robot)


@kernel
def see_lie(robot: EpuckState) -> None:
    """Put the shift or the place of a lie into the body frame of the liar."""
    fault, c, s = robot.fault, robot.heading[0], robot.heading[1]
    for area in range(2):
        x, y = fault.lie_in_arena[area, 0], fault.lie_in_arena[area, 1]
        if fault.lie.is_place:
            x, y = x - robot.pose[0], y - robot.pose[1]
        ahead, left = to_body(x, y, c, s)
        fault.lie.place[area, 0], fault.lie.place[area, 1] = ahead, left


@kernel
def is_stale(robot: EpuckState) -> bool:
    """The robot repeats what it told."""
    return bool(robot.fault.active[STALE])


@kernel
def is_lying(robot: EpuckState) -> bool:
    """The message that the robot just composed is to be a lie, as is drawn for every message."""
    fault = robot.fault
    if not fault.active[LIAR]:
        return False
    return fault.lie_probability >= 1.0 or unit(fault.stream, 0) < fault.lie_probability
