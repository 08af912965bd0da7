"""Draws of faults at the start of an episode, and their effects in a tick.

A draw for one kind of fault depends only on the seed of the world and on the names of the kind and
of the drawn parameter.
"""

import math

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import (
    DEAD,
    KINDS,
    LIAR,
    MUTE,
    N_KINDS,
    NOT_AGREED,
    PLACE_AGREED,
    TURN_AGREED,
    Fault,
    FaultNumbers,
)
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.equations.random_draws import GOLDEN, first_word, unit, unit_of
from swarm_forage_env.random_streams import NoiseSource, hash_of

CAUSE = int(NoiseSource.FAULT)
OF_KINDS = tuple(hash_of(name) for name in KINDS)
OF_SIDE_OF_WEAR, OF_SIDE_OF_LIE = hash_of("worn.side"), hash_of("liar.side")
OF_ALL_LIARS = hash_of("conspiracy")
OF_SHIFTS = tuple(hash_of(f"liar.shift.{area}") for area in range(2))
OF_PLACES = tuple(hash_of(f"liar.place.{area}") for area in range(2))
"""Hashes that name the draws."""

AGREED = {"no": NOT_AGREED, "turn": TURN_AGREED, "place": PLACE_AGREED}


def write_fault_numbers(scenario: EpuckScenario, out_numbers: Array | np.void) -> None:
    """Write the fault parameters of a scenario in the form that kernels read."""
    faults, areas = scenario.faults, scenario.areas[:2]
    for column, (_, kind) in enumerate(faults):
        out_numbers["share"][..., column] = kind.share
        start = min(round(kind.at / scenario.tick), scenario.n_ticks + 1)
        out_numbers["starts"][..., column] = start
    out_numbers["areas"] = 0.0
    out_numbers["areas"][..., : len(areas), :] = areas
    liar = faults.liar
    numbers = {
        "talks_when_dead": faults.dead.talks,
        "bias": faults.worn.bias,
        "noise_factor": faults.worn.noise_factor,
        "agreed": AGREED[liar.conspire],
        "arena": (scenario.arena.length, scenario.arena.width),
        "false_place_distance": scenario.false_place_distance,
        **liar.model_dump(include={"turn", "shift", "p", "own_p", "probability"}),
    }
    for name, value in numbers.items():
        out_numbers[name] = value


def name_faulty(scenario: EpuckScenario, out_faults: Array) -> None:
    """Reset records of shape (worlds, robots), and mark the robots that a scenario names."""
    Fault.restart(out_faults)
    for column, (_, kind) in enumerate(scenario.faults):
        out_faults["is_named"][:, list(kind.robots), column] = 1


@kernel
def draw_fault(
    numbers: FaultNumbers, seed: np.uint64, i: int, n_robots: int, out_fault: Fault
) -> None:
    """Draw and write the faults of robot i from the seed of its world, and its lie."""
    word = first_word(seed, i, CAUSE)
    out_fault.stream[0] = word
    for kind in range(N_KINDS):
        has_it = out_fault.is_named[kind] != 0 or is_drawn(numbers, seed, i, n_robots, kind)
        out_fault.kinds[kind] = 1 if has_it else 0
    side = side_of(word ^ OF_SIDE_OF_WEAR)
    out_fault.path_misread[0] = 1.0 + numbers.bias * side
    out_fault.path_misread[1] = 1.0 - numbers.bias * side
    make_lie(numbers, seed, word, out_fault)


@kernel
def is_drawn(numbers: FaultNumbers, seed: np.uint64, i: int, n_robots: int, kind: int) -> bool:
    """Return whether robot i has a kind of fault: the robots with the lowest draws have it."""
    if numbers.share[kind] == 0.0:
        return False
    n_faulty = math.floor(numbers.share[kind] * n_robots + 0.5)
    own, n_before = unit_of(first_word(seed, i, CAUSE) ^ OF_KINDS[kind]), 0
    for j in range(n_robots):
        other = unit_of(first_word(seed, j, CAUSE) ^ OF_KINDS[kind])
        if other < own or (other == own and j < i):
            n_before += 1
    return bool(n_before < n_faulty)


@kernel
def side_of(word: np.uint64) -> float:
    """Return a random sign, -1 or 1."""
    return -1.0 if unit_of(word) < 0.5 else 1.0


@kernel
def make_lie(numbers: FaultNumbers, seed: np.uint64, word: np.uint64, out_fault: Fault) -> None:
    """Write the lie that a robot sends if it is a liar; `word` is the robot's random word."""
    own, of_all = word, first_word(seed, 0, CAUSE) ^ OF_ALL_LIARS
    if numbers.agreed != NOT_AGREED:
        own = of_all
    lie = out_fault.lie
    lie.turn, lie.p = numbers.turn * side_of(own ^ OF_SIDE_OF_LIE), numbers.p
    lie.has_own_p, lie.is_place = numbers.own_p, numbers.agreed == PLACE_AGREED
    for area in range(2):
        lie.place[area, 0] = lie.place[area, 1] = 0.0
        if numbers.agreed == PLACE_AGREED:
            x, y = false_place(numbers, of_all ^ OF_PLACES[area], area)
        else:
            c, s = cos_sin(2.0 * math.pi * unit_of(own ^ OF_SHIFTS[area]))
            x, y = numbers.shift * c, numbers.shift * s
        out_fault.lie_in_arena[area, 0], out_fault.lie_in_arena[area, 1] = x, y


@kernel
def false_place(numbers: FaultNumbers, word: np.uint64, area: int) -> tuple[float, float]:
    """Draw uniformly a place in the arena at least `false_place_distance` from the true one [m]."""
    x, y = numbers.areas[area, 0], numbers.areas[area, 1]
    far = numbers.false_place_distance
    while True:
        dx, dy = x - numbers.areas[area, 0], y - numbers.areas[area, 1]
        if dx * dx + dy * dy >= far * far:
            return x, y
        x = numbers.arena[0] * (unit_of(word) - 0.5)
        y = numbers.arena[1] * (unit_of(word + GOLDEN) - 0.5)
        word += GOLDEN + GOLDEN


@kernel
def update_faults(robot: EpuckState, fault: Fault, world: EpuckWorldState) -> None:
    """Start the faults of a robot that are due, and update its lie in the body frame."""
    for kind in range(N_KINDS):
        has_begun = fault.kinds[kind] and world.ticks >= world.faults.starts[kind]
        robot.is_faulty[kind] = 1 if has_begun else 0
    is_gone = bool(robot.is_faulty[DEAD]) and not world.faults.talks_when_dead
    robot.is_silent = is_gone or bool(robot.is_faulty[MUTE])
    if robot.is_faulty[LIAR]:
        see_lie(robot, fault)


@kernel
def see_lie(robot: EpuckState, fault: Fault) -> None:
    """Write the shift or the place of a lie in the body frame of the liar."""
    c, s = robot.heading[0], robot.heading[1]
    for area in range(2):
        x, y = fault.lie_in_arena[area, 0], fault.lie_in_arena[area, 1]
        if fault.lie.is_place:
            x, y = x - robot.pose[0], y - robot.pose[1]
        ahead, left = to_body(x, y, c, s)
        fault.lie.place[area, 0], fault.lie.place[area, 1] = ahead, left


@kernel
def is_lying(robot: EpuckState, fault: Fault, world: EpuckWorldState) -> bool:
    """Return whether the message just composed is a lie, drawn for each message of a liar."""
    if not robot.is_faulty[LIAR]:
        return False
    probability = world.faults.probability
    return probability >= 1.0 or unit(fault.stream, 0) < probability
