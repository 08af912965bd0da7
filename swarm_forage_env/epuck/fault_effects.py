"""Effects of faults in a tick: when they begin, and where a lie lies as the liar sees it."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import DEAD, LIAR, MUTE, N_KINDS, STALE, Fault
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.equations.random_draws import unit


@kernel
def update_faults(robot: EpuckState, fault: Fault, world: EpuckWorldState) -> None:
    """Let the faults of a robot begin whose time has come, and see its lie from where it stands."""
    for kind in range(N_KINDS):
        has_begun = fault.kinds[kind] and world.ticks >= fault.starts[kind]
        robot.is_faulty[kind] = 1 if has_begun else 0
    is_gone = bool(robot.is_faulty[DEAD]) and not fault.talks_when_dead
    robot.is_silent = is_gone or bool(robot.is_faulty[MUTE])
    if robot.is_faulty[LIAR]:
        see_lie(robot, fault)


@kernel
def see_lie(robot: EpuckState, fault: Fault) -> None:
    """Put the shift or the place of a lie into the body frame of the liar."""
    c, s = robot.heading[0], robot.heading[1]
    for area in range(2):
        x, y = fault.lie_in_arena[area, 0], fault.lie_in_arena[area, 1]
        if fault.lie.is_place:
            x, y = x - robot.pose[0], y - robot.pose[1]
        ahead, left = to_body(x, y, c, s)
        fault.lie.place[area, 0], fault.lie.place[area, 1] = ahead, left


@kernel
def is_stale(robot: EpuckState) -> bool:
    """The robot repeats what it told."""
    return bool(robot.is_faulty[STALE])


@kernel
def is_lying(robot: EpuckState, fault: Fault) -> bool:
    """The message that the robot just composed is to be a lie, as is drawn for every message."""
    if not robot.is_faulty[LIAR]:
        return False
    return fault.lie_probability >= 1.0 or unit(fault.stream, 0) < fault.lie_probability
