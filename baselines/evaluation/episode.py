"""Episodes of any task: run a block of worlds from reset to the end, and measure each."""

import time
from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar, cast

from swarm_forage_env.device_loop import DeviceLoop, placed
from swarm_forage_env.episode import Episode, EpisodeKind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.interface import Controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import BaseScenario, HasEpisodes
from swarm_forage_env.task import task_of_episode
from swarm_forage_env.waypoints.episode import WaypointEpisode

AnyEpisode = Episode | ForagingEpisode | WaypointEpisode  # an episode of any task


EpisodeT = TypeVar("EpisodeT")


def run_episodes(  # noqa: PLR0913 which episodes, how they are run and observed
    scenario: HasEpisodes[EpisodeT],
    controller: Controller | Sequence[Controller],
    seeds: Sequence[int],
    physics: str | None = None,
    threads: int = 1,
    observer: Callable[[Loop], None] | None = None,
    device: str = "cpu",
) -> list[EpisodeT]:
    """Run one episode for each seed, side by side; each is the same when run alone.

    Foraging returns a `ForagingEpisode` for each seed.

    >>> from swarm_forage_env.controllers import find_controller
    >>> from swarm_forage_env.scenarios import find_scenario
    >>> scenario = find_scenario("es1", {"task.duration": 60.0})
    >>> [episode.seed for episode in run_episodes(scenario, find_controller("nc"), range(2))]
    [0, 1]

    Args:
        scenario: The world, from `find_scenario`.
        controller: The controller of all robots, from `find_controller` or `find_controllers`; or
            one for each world, which may differ in their parameters only.
        seeds: Seeds of the worlds; each episode depends on its own seed alone.
        physics: `rigid` or `kinematic`; None: the engine of the scenario.
        threads: Number of threads that run the worlds; results do not depend on it.
        observer: Called with the loop at the start and after every tick, on a CPU.
        device: `cpu` or `cuda`; episodes are the same, bit for bit. ConfigError if the scenario,
            engine or controller does not run there.
    """
    if observer is not None and device != "cpu":
        raise ConfigError(f"device={device!r}: an observer looks at every tick, on a CPU only")
    start = time.perf_counter()
    world = cast(BaseScenario, scenario)
    loop, running = _begun(world, controller, seeds, physics, threads, device)
    kind = loop.task.episode
    meter = kind.meter(running)
    if observer is not None:
        observer(loop)
    tick = 0
    while tick < world.n_ticks:
        until = tick + 1 if observer else min(meter.next_sample(tick), world.n_ticks)
        running.run(until - tick)
        tick = until
        meter.sample(tick)
        if observer is not None:
            observer(loop)
    running.check()
    results = meter.results()
    wall = (time.perf_counter() - start) / len(seeds)
    return [
        kind.episode(
            scenario=world.name,
            controller=each.name,
            seed=seed,
            physics=physics or loop.task.physics,
            n_robots=loop.world.n_robots,
            duration_s=world.n_ticks * world.tick,
            wall_s=wall,
            **numbers,
        )
        for each, seed, numbers in zip(loop.controllers, seeds, results, strict=True)
    ]


WARM_UP_TICKS = 50  # enough for bodies to touch, for which the engine `rigid` has a kernel


def compile_episodes(
    scenario: BaseScenario, controller: Controller, physics: str | None, device: str = "cpu"
) -> None:
    """Compile every kernel of the episodes, so that workers find them in the cache.

    ConfigError if the scenario, engine or controller does not run on the device.
    """
    loop, running = _begun(scenario, controller, (0,), physics, 1, device)
    meter = loop.task.episode.meter(running)
    for tick in range(1, min(WARM_UP_TICKS, scenario.n_ticks) + 1):
        running.step()
        meter.sample(tick)
    meter.sample(scenario.n_ticks)  # the measurements at the end


def _begun(
    scenario: BaseScenario,
    controller: Controller | Sequence[Controller],
    seeds: Sequence[int],
    physics: str | None,
    threads: int,
    device: str,
) -> tuple[Loop, Loop | DeviceLoop]:
    """Reset the worlds; return their loop on the CPU and the loop on the device that runs them."""
    is_alike = not isinstance(controller, Sequence)  # worlds of one controller reset on the device
    loop = Loop(scenario, controller, seeds, physics, threads, is_blank=is_alike)
    running = placed(loop, device)
    if is_alike:
        running.reset(seeds)
    return loop, running


def kind_of_episode(episode: object) -> EpisodeKind:
    """Return the kind of an episode: its fields, metrics and score."""
    return task_of_episode(episode).episode


def present_values(episodes: Iterable[object], metric: str, factor: float = 1.0) -> list[float]:
    """Return a metric, times a factor, of the episodes that have it."""
    values = (getattr(each, metric) for each in episodes)
    return [factor * value for value in values if value is not None]
