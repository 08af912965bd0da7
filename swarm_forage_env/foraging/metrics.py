"""Metrics of an episode: pure functions of the state.

The robots of a world are consecutive in arrays of rows. The localisation error, which is sampled
often, takes records.
"""

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Bool, Float64, Int32, Int64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.foraging.records import RobotState, Situation, WorldState
from swarm_forage_env.foraging.scoring import distance_to_kind
from swarm_forage_env.interface import Kernel

lane: Kernel
first_world: Kernel
end_world: Kernel
"""Free names of the templates: lanes."""


def knows_both_areas_share(
    path_ticks: Int64[Array, " rows"], n_worlds: int, n_ticks: int
) -> Float64[Array, " worlds"]:
    """Return the share of robots on the path, mean over the second half of the episode.

    A robot is on the path while it reports that it knows both areas, so that its forage layer
    drives it. `n_ticks` is the length of the episode so far, or of the whole one [ticks].

    Source: TR, Sections 5.1 and 6.1.3 (the definition is chosen, the TR gives none).
    """
    counted = max(1, n_ticks - n_ticks // 2)
    return np.asarray(path_ticks.reshape(n_worlds, -1).mean(axis=1) / counted)


def recruited_at(
    first_visit: Int64[Array, "worlds robots areas"], tick: float
) -> list[tuple[float, ...]]:
    """Return the times at which robots of each world had visited both areas [s], earliest first.

    Robots that have not visited both are left out.

    Source: TR, Section 6.1.1.
    """
    is_recruited = (first_visit >= 0).all(axis=2)
    last = np.where(is_recruited, first_visit.max(axis=2), np.iinfo(np.int64).max)
    times, n = (np.sort(last) * tick).tolist(), is_recruited.sum(axis=1).tolist()
    return [tuple(own[:k]) for own, k in zip(times, n, strict=True)]


def nearest_areas(
    worlds: Array, places: Float64[Array, "rows areas 2"]
) -> Float64[Array, "rows areas 2"]:
    """Return the centres of the nest and prey area nearest to the two places of each row [m].

    Rows of a world are consecutive; `worlds` are the records of all worlds.
    """
    n_areas = worlds["n_areas"].max()
    centres, kinds = worlds["areas"][:, :n_areas], worlds["kinds"][:, :n_areas]
    own = places.reshape(len(worlds), -1, 2, 2)
    nearest_of = np.empty_like(own)
    for kind in (NEST, PREY):
        away = own[:, :, None, kind] - centres[:, None]
        squared = np.where((kinds == kind)[:, None], (away**2).sum(axis=3), np.inf)
        nearest = squared.argmin(axis=2)
        nearest_of[:, :, kind] = np.take_along_axis(centres, nearest[:, :, None], axis=1)
    return nearest_of.reshape(places.shape)


@kernel
def localisation_error(
    robot: RobotState, situation: Situation, area: int, world: WorldState
) -> float:
    """Return the distance from the believed place of an area to the nearest one of its kind [m]."""
    ahead, left = situation.areas[area, 0], situation.areas[area, 1]
    dx, dy = to_outer(ahead, left, robot.heading[0], robot.heading[1])
    return distance_to_kind(robot.pose[0] + dx, robot.pose[1] + dy, area, world)


def add_errors(  # noqa: PLR0913 inputs and outputs
    robots: Array,
    estimators: Array,
    worlds: Array,
    is_meant: Bool[Array, "worlds robots"],
    out_sum: Float64[Array, " worlds"],
    out_count: Int64[Array, " worlds"],
    span: tuple[int, int],
) -> None:
    """Add the localisation error of each area that a robot knows to the sums of some worlds.

    Only robots with `is_meant` count. One lane sums each world, robot by robot, so that the sum is
    the same on all devices. Free names: lanes.
    """
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        for i in range(is_meant.shape[1] if lane() == 0 else 0):
            robot, situation = robots[w, i], estimators[w, i].situation
            for area in range(2):
                if is_meant[w, i] and situation.known[area]:
                    out_sum[w] += localisation_error(robot, situation, area, worlds[w])
                    out_count[w] += 1


def count_on_path(
    robots: Array, at: int, out: Int32[Array, "worlds moments"], span: tuple[int, int]
) -> None:
    """Count the robots of some worlds on the path, in column `at`. Free names: lanes."""
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        for i in range(robots.shape[1] if lane() == 0 else 0):
            robot = robots[w, i]
            if robot.known[NEST] and robot.known[PREY]:
                out[w, at] += 1
