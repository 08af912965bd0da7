"""Heat maps of the robots' positions in one episode of each controller.

The positions are those that `evaluate --trajectories` has written, or else the same episode is run
again, whose round trips must be those that the dataset holds.
"""

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.dataset_reader import EpisodeGroup
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.figures.base import SELECTION, PlotOptions, figure
from baselines.evaluation.heat_maps import Density, density_panels
from baselines.evaluation.trajectories import find_trajectory, read_trajectory
from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import stage_of, task_of

LOGGER = logging.getLogger("swarm-forage")

CELL = 0.02  # side of a cell, about: the cells fill the arena [m]
MAX_PANELS = 6  # panels, at most


@dataclass(frozen=True)
class Job:
    """An episode to draw."""

    scenario: Scenario
    seed: int
    controller: str  # by its name
    places: Iterator[Array]  # of the robots, after each tick or after all of them
    is_kept: bool = False  # they are those of a trajectory


@figure("paths", *SELECTION, "seed")
def draw(options: PlotOptions) -> Figure:
    """Draw the maps, from a dataset or from SCENARIO CONTROLLER..., a panel for each."""
    is_dataset = Path(options.sources[0]).is_dir()
    jobs = _evaluated(options) if is_dataset else _asked(options)
    if len(jobs) > MAX_PANELS:
        raise ConfigError(
            f"{len(jobs)} configurations: at most {MAX_PANELS} in a figure; choose with"
            " --controller or --scenario"
        )
    densities = {title: _density(job) for title, job in jobs.items()}
    setups = {title.partition("\n")[0] for title in densities}
    note = f"one episode each, seed {', '.join(sorted({str(job.seed) for job in jobs.values()}))}"
    if len(setups) == 1:
        note = f"{min(setups)}, {note}"
        densities = {title.partition("\n")[2]: each for title, each in densities.items()}
    made = "as evaluated" if all(job.is_kept for job in jobs.values()) else "run for this figure"
    text = (
        f"Robots per m^2, mean over one episode, in cells of {1000 * CELL:g} mm; {made}. The"
        " frame has the colour of the controller."
    )
    return density_panels(densities, options.caption(text, note=note))


def _evaluated(options: PlotOptions) -> dict[str, Job]:
    """The first episode of every group, or the one with the seed, by title."""
    jobs: dict[str, Job] = {}
    for group in options.foraging_groups:
        seeds = [episode.seed for episode in group.episodes]
        seed = seeds[0] if options.seed is None else options.seed
        if seed not in seeds:
            raise ConfigError(
                f"--seed {seed}: {group.label()} has the seeds {seeds[0]} to {seeds[-1]} here"
            )
        title = f"{group.setup()}\n{group.label()}"
        if trajectory := find_trajectory(options.sources, group.key, seed):
            jobs[title] = Job(group.model(), seed, group.label(), _places(trajectory), True)
            continue
        _check_same_code(group)
        trips = group.episodes[seeds.index(seed)].round_trips
        jobs[title] = _run(title, group.configuration(), seed, trips)
    return jobs


def _asked(options: PlotOptions) -> dict[str, Job]:
    scenario, *controllers = options.sources
    if not controllers or {"scenario", "controller"} & options.choices.keys():
        raise ConfigError(
            f"{' '.join(options.sources)}: must be the folder of a dataset, or a scenario and"
            " controllers without further choice, as in swarm-forage plot paths es1 nc ssgikf"
        )
    request = EvaluateOptions(scenario, controllers, episodes=1, seed=options.seed or 0)
    jobs = {}
    for each in request.configurations():
        if task_of(each.scenario).name != "foraging":
            raise ConfigError(
                f"scenario '{each.scenario.name}': paths are shown of robots that forage, as in es1"
            )
        title = f"{each.scenario.name}, {each.physics}\n{each.label}"
        jobs[title] = _run(title, each, request.seeds()[0])
    return jobs


def _check_same_code(group: EpisodeGroup) -> None:
    now = group.configuration().code
    if now != group.code:
        raise ConfigError(
            f"{group.label()}: was run by another version of swarm-forage (code {group.code}, this"
            f" is {now}), so the episode cannot be run again; evaluate into another folder, or"
            f" name scenario and controller: swarm-forage plot paths {group.scenario}"
            f" {group.label()}"
        )


def _places(file: Path) -> Iterator[Array]:
    """Where the robots were after every tick: x and y, a row for each."""
    table = read_trajectory(file)
    places = np.stack([table["x"].to_numpy(), table["y"].to_numpy()], axis=1)
    yield np.asarray(places[table["t"].to_numpy() > 0.0], np.float64)


def _run(title: str, of: ExperimentConfig, seed: int, trips: int | None = None) -> Job:
    """An episode that is run as it is drawn; ConfigError then, if it makes other round trips."""

    def places() -> Iterator[Array]:
        LOGGER.warning("running %s, seed %d", title.replace("\n", ", "), seed)
        loop = Loop(of.scenario, of.controller, [seed], of.physics)
        for _ in range(of.scenario.n_ticks):
            loop.step()
            yield loop.world.robots["pose"][0, :, :2]
        made = int(loop.world.robots["round_trips"].sum())
        if trips is not None and made != trips:
            raise ConfigError(
                f"seed {seed} gave {made} round trips, the dataset holds {trips}: it was made"
                " with other libraries or on another machine; evaluate into another folder"
            )

    return Job(of.scenario, seed, of.label, places())


def _density(job: Job) -> Density:
    """The mean over all ticks of the robots in each cell."""
    scenario = job.scenario
    size = scenario.arena.length, scenario.arena.width
    n_cells = [max(1, round(side / CELL)) for side in size]
    counts = np.zeros(n_cells)
    for place in job.places:
        cells = np.clip(((place / size + 0.5) * n_cells).astype(np.int64), 0, np.array(n_cells) - 1)
        np.add.at(counts, (cells[:, 0], cells[:, 1]), 1.0)
    cell_area = size[0] * size[1] / counts.size
    values = counts.T / (scenario.n_ticks * cell_area)
    return values, stage_of(scenario, job.controller)
