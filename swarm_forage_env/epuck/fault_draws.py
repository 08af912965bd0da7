"""Draws of faults at the start of an episode: who is faulty, and how.

What is drawn for one kind of fault depends on the seed of the world and on the names of the kind
and of the number alone.
"""

import math
from collections.abc import Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64, UInt64
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.epuck.faults import FaultKind, Liar, Worn
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.equations import random_draws
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.random_streams import NoiseSource, hash_of, streams

draw_unit = entry_point(random_draws.unit)

Places = Float64[Array, "robots areas 2"]


def draw_faults(scenario: EpuckScenario, seeds: Sequence[int], out_faults: Array) -> None:
    """Write the faults of the robots of worlds to their records, which are as at the start."""
    if scenario.faults.is_any:
        for seed, out_fault in zip(seeds, out_faults, strict=True):
            _draw_faults(scenario, seed, out_fault)


def _draw_faults(scenario: EpuckScenario, seed: int, out_fault: Array) -> None:
    words = streams([seed], len(out_fault), NoiseSource.FAULT)
    out_fault["stream"][:, 0] = words
    for column, (name, kind) in enumerate(scenario.faults.kinds()):
        out_fault["kinds"][:, column] = _whose(name, kind, words)
        out_fault["starts"][:, column] = min(round(kind.at / scenario.tick), scenario.n_ticks + 1)
    out_fault["talks_when_dead"] = scenario.faults.dead.talks
    _wear(scenario.faults.worn, words, out_fault)
    _make_lies(scenario, seed, words, out_fault)


def uniform(words: UInt64[Array, " robots"], name: str) -> Float64[Array, " robots"]:
    """A uniform number in [0, 1) for each robot, which is drawn for what is named so alone."""
    own = words ^ hash_of(name)
    return np.array([draw_unit(own, robot) for robot in range(len(own))])


def _whose(name: str, kind: FaultKind, words: UInt64[Array, " robots"]) -> Bool[Array, " robots"]:
    """The robots that have a kind of fault: those named, or those whose draws are lowest."""
    found = np.zeros(len(words), np.bool_)
    found[list(kind.robots)] = True
    if kind.share > 0.0:
        n_faulty = math.floor(kind.share * len(words) + 0.5)
        found[np.argsort(uniform(words, name), kind="stable")[:n_faulty]] = True
    return found


def _wear(worn: Worn, words: UInt64[Array, " robots"], out_fault: Array) -> None:
    """Write by how much each robot would misread its wheels if it is worn."""
    side = np.where(uniform(words, "worn.side") < 0.5, -1.0, 1.0)
    out_fault["path_misread"] = 1.0 + worn.bias * np.stack([side, -side], axis=1)
    out_fault["noise_factor"] = worn.noise_factor


def _make_lies(
    scenario: EpuckScenario, seed: int, words: UInt64[Array, " robots"], out_fault: Array
) -> None:
    """Write what each robot would tell if it is a liar."""
    liar, lie = scenario.faults.liar, out_fault["lie"]
    common = streams([seed], 1, NoiseSource.FAULT) ^ hash_of("conspiracy")
    conspires = liar.conspire != "no"
    own = np.broadcast_to(common, words.shape) if conspires else words
    side = np.where(uniform(own, "liar.side") < 0.5, -1.0, 1.0)
    lie["turn"], lie["p"], lie["has_own_p"] = liar.turn * side, liar.p, liar.own_p
    lie["is_place"] = liar.conspire == "place"
    out_fault["lie_probability"] = liar.probability
    if liar.conspire == "place":
        out_fault["lie_in_arena"] = _false_places(scenario, common)
    else:
        out_fault["lie_in_arena"] = _shifts(liar, own)


def _shifts(liar: Liar, words: UInt64[Array, " robots"]) -> Places:
    """By how much each robot shifts each area, world frame [m]."""
    shifts = np.empty((len(words), 2, 2))
    for area in range(2):
        angles = 2.0 * math.pi * uniform(words, f"liar.shift.{area}")
        write_vectors(liar.shift, angles, shifts[:, area])
    return shifts


@entry_point
def write_vectors(
    length: float, angles: Float64[Array, " robots"], out: Float64[Array, "robots 2"]
) -> None:
    """Write the vectors of a length [m] in these directions [rad]."""
    for i in range(angles.shape[0]):
        c, s = cos_sin(angles[i])
        out[i, 0], out[i, 1] = length * c, length * s


def _false_places(scenario: EpuckScenario, word: UInt64[Array, "1"]) -> Float64[Array, "areas 2"]:
    """A false place of each area in the arena, world frame [m].

    Uniform among those at least `false_place_distance` from the true one.
    """
    arena, far = scenario.arena, scenario.false_place_distance
    found = []
    for area, centre in enumerate(scenario.areas):
        own = word ^ hash_of(f"liar.place.{area}")
        place = centre
        while np.hypot(*(place - centre)) < far:
            x, y = (draw_unit(own, 0) - 0.5 for _ in range(2))
            place = np.array([arena.length * x, arena.width * y])
        found.append(place)
    return np.array(found)
