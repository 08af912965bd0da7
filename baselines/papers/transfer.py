"""Transfer: each bundled policy in its training worlds and in others, against SGIKF.

Not in the papers: the experiment itself. And chosen here:
- the worlds are es1 with one thing changed, and the other worlds of two or more areas;
- the policies are the bundled ones; `learned-ppo` is of the algorithm that does best on the ladder,
  PPO, by this project's own command and with its default seed: the ladder keeps no weights;
- with more than ten robots the arena grows with the swarm, in the proportions of es1, and the
  distance of the areas stays the same; fewer robots have the arena of es1;
- if the areas are farther apart, the arena is longer by the same amount; it is never shorter;
- walls and pillars stand half-way between the start and the areas: a pillar 10 cm wide, four of
  them, walls 60 cm long across the straight way, and walls with a gate 40 cm wide;
- int16: the numbers of a message are rounded to 2^16 steps, as a board sends them;
- the score is the round trips of all robots, under the same seeds for all;
- a policy falls below in a world if it makes fewer round trips than `ssgikf`, with a Mann-Whitney p
  below 0.01.
"""

import json
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from baselines.evaluation.statistics import compare
from baselines.evaluation.tables import markdown
from baselines.papers.claim_types import Order, above
from baselines.papers.experiments import Experiment, Results, round_trips, sample
from baselines.papers.figures import RatioMaps, ratio_of_trips
from baselines.papers.paper import Paper

BASE = "ssgikf"

POLICIES = (
    "dsgiff-penalised", "learned-weighting", "learned-motion", "learned-both", "learned-sceptical",
    "learned-robust", "learned-ppo", "learned-generalist",
)  # fmt: skip
"""Controllers compared with `ssgikf`: the best hand-written filter, and the policies."""

LENGTH, WIDTH, DISTANCE, N_ROBOTS, WHEEL_NOISE = 1.7, 1.2, 1.5, 10, 0.058
"""Values of es1: arena and distance of the areas [m], number of robots, noise of the wheels."""


class World(NamedTuple):
    """Scenario and the changes made to it."""

    scenario: str = "es1"
    settings: tuple[str, ...] = ()
    parameters: str = ""  # parameters of every controller: `payload=int16`
    physics: str | None = None  # None: the engine of all others


def changed(*settings: str) -> World:
    """Return es1 with these settings changed."""
    return World("es1", settings)


def with_robots(n: int) -> World:
    """Return es1 with n robots, at the density of es1 from ten robots on."""
    grown = math.sqrt(max(1.0, n / N_ROBOTS))
    return changed(
        f"task.n_robots={n}", f"arena.length={grown * LENGTH:.3g}",
        f"arena.width={grown * WIDTH:.3g}", f"task.start_radius={grown * 0.2:.3g}",
    )  # fmt: skip


def with_distance(distance: float) -> World:
    """Return es1 with areas at this distance [m], in an arena longer by the same amount."""
    length = max(LENGTH, LENGTH + distance - DISTANCE)
    return changed(f"task.area_distance={distance:g}", f"arena.length={length:.3g}")


def with_obstacles(radius: float, *each: Sequence[Sequence[float]]) -> World:
    """Return es1 with pillars or walls of this radius through these points [m], on both sides."""
    both = [[[side * x, y] for x, y in points] for points in each for side in (1, -1)]
    made = [{"points": points, "radius": radius} for points in both]
    return changed(f"obstacles={json.dumps(made)}")


AXES: Mapping[str, Mapping[str, World]] = {
    "robots": {f"{n}": with_robots(n) for n in (1, 2, 3, 4, 5, 10, 20, 30, 50, 100)},
    "distance of the areas [m]": {
        f"{distance:g}": with_distance(distance) for distance in (0.6, 1.0, 1.5, 2.0, 3.0, 4.0)
    },
    "noise of the wheels, of es1's": {
        f"{k:g}": changed(f"sensors.wheel_noise={k * WHEEL_NOISE:.3g}")
        for k in (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
    },
    "range of the radio [m]": {
        f"{reach:g}": changed(f"radio.max_range={reach:g}")
        for reach in (0.05, 0.08, 0.1, 0.15, 0.2, 0.3, 0.6)
    },
    "faulty robots, 20 %": {
        "liars": changed("faults.liar.share=0.2"),
        "one lie": changed("faults.liar.share=0.2", "faults.liar.conspire=place"),
        "deaf": changed("faults.deaf.share=0.2"),
        "dead": changed("faults.dead.share=0.2", "faults.dead.at=300"),
        "worn": changed("faults.worn.share=0.2"),
        "blind": changed("faults.blind.share=0.2"),
    },
    "obstacles": {
        "pillar": with_obstacles(0.05, [(0.45, 0.0)]),
        "pillars": with_obstacles(0.05, [(0.45, 0.15)], [(0.45, -0.15)]),
        "walls": with_obstacles(0.01, [(0.45, -0.3), (0.45, 0.3)]),
        "gates": with_obstacles(0.01, [(0.45, 0.2), (0.45, 0.6)], [(0.45, -0.2), (0.45, -0.6)]),
    },
    "engine and payload": {
        "rigid": World(physics="rigid"),
        "int16": World(parameters="payload=int16"),
        "both": World(parameters="payload=int16", physics="rigid"),
    },
    "other worlds": {
        name.removesuffix("-dodecagon"): World(name)
        for name in ("real", "es2", "es3", "mg1-dodecagon", "two-prey", "two-nests", "moving-prey")
    },
}  # fmt: skip
"""Worlds by what is changed, and by its value."""

WORLDS = [world for each in AXES.values() for world in each.values()]


def experiment(controller: str, world: World) -> Experiment:
    """Return the experiment of a controller in a world."""
    joint = ("," if ":" in controller else ":") if world.parameters else ""
    name = controller + joint + world.parameters
    return Experiment(world.scenario, name, world.settings, world.physics)


def pair(policy: str, world: World) -> tuple[Experiment, Experiment]:
    """Return the experiments of a policy and of `ssgikf` in a world."""
    return experiment(policy, world), experiment(BASE, world)


def falls_below(results: Results, policy: str, world: World) -> bool:
    """Return whether a policy makes fewer round trips than `ssgikf`."""
    ours, base = (sample(results, each, round_trips) for each in pair(policy, world))
    return above(compare(base, ours))


CAPTION = (
    f"Round trips of {BASE}, and of others as a multiple of them, with one thing changed in es1"
    " and in other worlds."
)


def table(results: Results, policies: Sequence[str]) -> str:
    """Return the table of worlds in which each policy falls below `ssgikf`."""
    lines = []
    for policy in policies:
        below = [
            f"{axis}: {name} ({ratio_of_trips(results, *pair(policy, world)):.2f})"
            for axis, worlds in AXES.items()
            for name, world in worlds.items()
            if falls_below(results, policy, world)
        ]
        lines.append((policy, f"{len(below)} of {len(WORLDS)}", "; ".join(below) or "nowhere"))
    return markdown(("policy", f"worlds below {BASE}", "which, with the ratio"), lines)


LEFT_OPEN = {"The experiment": "baselines.papers.transfer"}


def paper(policies: Sequence[str]) -> Paper:
    """Return the experiment of these controllers in every world.

    The claim is a question that no paper answers: is a policy above `ssgikf` in all worlds?
    """
    claims = tuple(
        Order(f"{policy} above {BASE} in every world", tuple(pair(policy, each) for each in WORLDS))
        for policy in policies
    )
    ratios = {
        axis: {
            each: {name.replace("-", "\n"): pair(each, world) for name, world in worlds.items()}
            for each in (BASE, *policies)
        }
        for axis, worlds in AXES.items()
    }
    figures = (RatioMaps("transfer", CAPTION, ratios),)
    return Paper(
        "transfer", claims, figures, 10, LEFT_OPEN, lambda results: table(results, policies)
    )


PAPER = paper(POLICIES)
"""Experiment of every bundled policy in every world."""
