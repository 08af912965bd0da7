"""Episodes of any task: run a block of worlds from reset to the end, and measure each."""

import time
from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar, cast

from swarm_forage_env.episode import Episode, EpisodeKind
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.interface import Controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import BaseScenario, HasEpisodes
from swarm_forage_env.task import task_of_episode
from swarm_forage_env.waypoints.episode import WaypointEpisode

AnyEpisode = Episode | ForagingEpisode | WaypointEpisode  # an episode of any task


EpisodeT = TypeVar("EpisodeT")


def run_episodes(
    scenario: HasEpisodes[EpisodeT],
    controller: Controller,
    seeds: Sequence[int],
    physics: str | None = None,
    threads: int = 1,
    observer: Callable[[Loop], None] | None = None,
) -> list[EpisodeT]:
    """Run one episode for each seed, side by side; each is the same when run alone.

    Foraging gives a `ForagingEpisode` for each.

    >>> from swarm_forage_env.controllers import find_controller
    >>> from swarm_forage_env.scenarios import find_scenario
    >>> scenario = find_scenario("es1", {"task.duration": 60.0})
    >>> [episode.seed for episode in run_episodes(scenario, find_controller("nc"), range(2))]
    [0, 1]

    Args:
        scenario: The world, from `find_scenario`.
        controller: The controller of all robots, from `find_controller` or `find_controllers`.
        seeds: Seeds of the worlds; each episode depends on its own seed alone.
        physics: `rigid` or `kinematic`; None: the engine of the scenario.
        threads: Threads that run the worlds; they change nothing but the computing time.
        observer: Called with the loop at the start and after every tick.
    """
    start = time.perf_counter()
    world = cast(BaseScenario, scenario)
    loop = Loop(world, controller, seeds, physics, threads)
    kind = loop.task.episode
    meter = kind.meter(loop)
    if observer is not None:
        observer(loop)
    tick = 0
    while tick < world.n_ticks:
        until = tick + 1 if observer else min(meter.next_sample(tick), world.n_ticks)
        loop.run(until - tick)
        tick = until
        meter.sample(tick)
        if observer is not None:
            observer(loop)
    results = meter.results()
    wall = (time.perf_counter() - start) / len(seeds)
    return [
        kind.episode(
            scenario=world.name,
            controller=controller.name,
            seed=seed,
            physics=physics or loop.task.physics,
            n_robots=loop.world.n_robots,
            duration_s=world.n_ticks * world.tick,
            wall_s=wall,
            **numbers,
        )
        for seed, numbers in zip(seeds, results, strict=True)
    ]


def kind_of_episode(episode: object) -> EpisodeKind:
    """What an episode is judged by."""
    return task_of_episode(episode).episode


def present_values(episodes: Iterable[object], metric: str, factor: float = 1.0) -> list[float]:
    """A metric of the episodes that have it, times a factor."""
    values = (getattr(each, metric) for each in episodes)
    return [factor * value for value in values if value is not None]
