"""Heat maps of the robots' positions in one episode of each controller, which is run again.

A dataset keeps no positions. The same configuration and seed give the same episode to the last
bit, so it is run again; its round trips must be those that the dataset holds.
"""

import logging
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.dataset_reader import EpisodeGroup
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.figures.base import FIGURES, SELECTION, PlotOptions
from baselines.evaluation.heat_maps import Density, density_panels
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import task_of

LOGGER = logging.getLogger("swarm-forage")

CELL = 0.02
"""Side of a cell, about: the cells fill the arena [m]."""

MOST = 6
"""Panels, at most."""


class PathMaps:
    """The figure `paths`: a heat map of each controller's robots over one episode."""

    options = SELECTION | {"seed"}

    def draw(self, options: PlotOptions) -> Figure:
        """Draw the maps, from a dataset or from SCENARIO CONTROLLER..., a panel for each."""
        is_dataset = Path(options.sources[0]).is_dir()
        jobs = _kept(options) if is_dataset else _asked(options)
        if len(jobs) > MOST:
            raise ConfigError(
                f"{len(jobs)} configurations: at most {MOST} in a figure; choose with --controller"
                " or --scenario"
            )
        densities = {}
        for title, (configuration, seed, trips) in jobs.items():
            scenario = configuration.scenario
            if task_of(scenario).name != "foraging":
                raise ConfigError(
                    f"scenario '{scenario.name}': paths are shown of robots that forage, as in es1"
                )
            LOGGER.warning("running %s, seed %d", title.replace("\n", ", "), seed)
            densities[title] = _run(configuration, scenario, seed, trips)
        text = (
            f"Robots per m^2, mean over one episode, in cells of {1000 * CELL:g} mm; run for this"
            f" figure (seed {next(iter(jobs.values()))[1]})."
        )
        return density_panels(densities, options.caption(text))


FIGURES.register("paths")(PathMaps())

Jobs = dict[str, tuple[ExperimentConfig, int, int | None]]
"""By title: what to run, its seed, and the round trips it must have."""


def _kept(options: PlotOptions) -> Jobs:
    """The first episode of every group, or the one with the seed."""
    jobs: Jobs = {}
    for group in options.foraging_groups:
        seeds = [episode.seed for episode in group.episodes]
        seed = seeds[0] if options.seed is None else options.seed
        if seed not in seeds:
            raise ConfigError(
                f"--seed {seed}: {group.label()} has the seeds {seeds[0]} to {seeds[-1]} here"
            )
        _check_same_code(group)
        trips = group.episodes[seeds.index(seed)].round_trips
        jobs[f"{group.setup()}\n{group.label()}"] = (group.configuration(), seed, trips)
    return jobs


def _asked(options: PlotOptions) -> Jobs:
    """The episodes that SCENARIO CONTROLLER... name."""
    scenario, *controllers = options.sources
    if not controllers or {"scenario", "controller"} & options.given.keys():
        raise ConfigError(
            f"{' '.join(options.sources)}: must be the folder of a dataset, or a scenario and"
            " controllers without further choice, as in swarm-forage plot paths es1 nc ssgikf"
        )
    request = EvaluateOptions(scenario, controllers, episodes=1, seed=options.seed or 0)
    return {
        f"{each.scenario.name}, {each.physics}\n{each.label}": (each, request.seeds()[0], None)
        for each in request.configurations()
    }


def _check_same_code(group: EpisodeGroup) -> None:
    now = group.configuration().code
    if now != group.code:
        raise ConfigError(
            f"{group.label()}: was run by another version of swarm-forage (code {group.code}, this"
            f" is {now}), so the episode cannot be run again; evaluate into another folder, or"
            f" name scenario and controller: swarm-forage plot paths {group.scenario}"
            f" {group.label()}"
        )


def _run(
    configuration: ExperimentConfig, scenario: Scenario, seed: int, trips: int | None
) -> Density:
    """Run the episode and count the robots in each cell over all ticks."""
    loop = Loop(scenario, configuration.controller, [seed], configuration.physics)
    size = scenario.arena.length, scenario.arena.width
    n_cells = [max(1, round(side / CELL)) for side in size]
    counts = np.zeros(n_cells)
    for _ in range(scenario.n_ticks):
        loop.step()
        place = loop.world.robots["pose"][0, :, :2] / size + 0.5
        cells = np.clip((place * n_cells).astype(np.int64), 0, np.array(n_cells) - 1)
        np.add.at(counts, (cells[:, 0], cells[:, 1]), 1.0)
    made = int(loop.world.robots["round_trips"].sum())
    if trips is not None and made != trips:
        raise ConfigError(
            f"seed {seed} gave {made} round trips, the dataset holds {trips}: it was made with"
            " other libraries or on another machine; evaluate into another folder"
        )
    cell_area = size[0] * size[1] / counts.size
    areas = {name: tuple(map(float, at)) for name, at in zip(AREAS, scenario.areas, strict=True)}
    radius = scenario.task.area_radius
    return Density(counts.T / (scenario.n_ticks * cell_area), size, areas, radius)  # type: ignore[arg-type]


AREAS = ("nest", "prey")
"""In the order of the world's areas."""
