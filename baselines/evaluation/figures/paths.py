"""Heat maps of the robots' positions in one episode of each controller.

The positions come from a trajectory file of `evaluate --trajectories`. Without one the episode is
run again, and its round trips must equal those in the dataset.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.console import count_noun
from baselines.evaluation.dataset import LOGGER
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

CELL = 0.02  # approximate side of a cell [m]; the cells fill the arena


@dataclass(frozen=True)
class PathDensity:
    """The episode of one panel."""

    setup: str
    controller: str  # its label
    seed: int
    density: Density
    is_stored: bool = False  # the density is that of a trajectory file


@figure("paths", *SELECTION, "seed")
def draw(options: PlotOptions) -> Figure:
    """Draw a map for each group of a dataset, or for each controller of SCENARIO CONTROLLER..."""
    is_dataset = Path(options.sources[0]).is_dir()
    shown = list(_evaluated(options) if is_dataset else _of_controllers(options))
    setups = {each.setup for each in shown}
    note = f"one episode each, seed {', '.join(sorted({str(each.seed) for each in shown}))}"
    if len(setups) == 1:
        note = f"{min(setups)}, {note}"
    densities = {
        each.controller if len(setups) == 1 else f"{each.setup}\n{each.controller}": each.density
        for each in shown
    }
    made = "as evaluated" if all(each.is_stored for each in shown) else "run for this figure"
    text = (
        f"Robots per m^2, mean over one episode, in cells of {1000 * CELL:g} mm; {made}. The"
        " frame has the colour of the controller."
    )
    return density_panels(densities, options.caption(text, note=note))


def _evaluated(options: PlotOptions) -> Iterator[PathDensity]:
    """Yield the first episode of every group, or the one with the chosen seed."""
    for group in options.foraging_groups:
        seeds = [episode.seed for episode in group.episodes]
        seed = seeds[0] if options.seed is None else options.seed
        if seed not in seeds:
            raise ConfigError(
                f"--seed {seed}: {group.label()} in {group.setup()} has"
                f" {count_noun(len(seeds), 'seed')}, {seeds[0]} to {seeds[-1]}"
            )
        named = group.setup(), group.label(), seed
        if trajectory := find_trajectory(options.sources, group.key, seed):
            density = _density(group.model(), group.label(), _stored_places(trajectory))
            yield PathDensity(*named, density, is_stored=True)
        else:
            _check_same_code(group)
            trips = group.episodes[seeds.index(seed)].round_trips
            yield _run(group.configuration(), *named, trips)


def _of_controllers(options: PlotOptions) -> Iterator[PathDensity]:
    scenario, *controllers = options.sources
    if not controllers or {"scenario", "controller"} & options.choices.keys():
        raise ConfigError(
            f"{' '.join(options.sources)}: must be the folder of a dataset, or a scenario and"
            " controllers without other options, as in swarm-forage plot paths es1 nc ssgikf"
        )
    request = EvaluateOptions(scenario, controllers, episodes=1, seed=options.seed or 0)
    for each in request.configurations():
        if task_of(each.scenario).name != "foraging":
            raise ConfigError(
                f"scenario '{each.scenario.name}': must be one in which robots forage, such as es1"
            )
        setup = f"{each.scenario.name}, {each.physics}"
        yield _run(each, setup, each.label, request.seeds()[0], None)


def _check_same_code(group: EpisodeGroup) -> None:
    now = group.configuration().code
    if now != group.code:
        raise ConfigError(
            f"{group.label()}: was run by another version of swarm-forage (code {group.code}, this"
            f" is {now}), so the episode cannot be run again; evaluate into another folder, or"
            f" name scenario and controller: swarm-forage plot paths {group.scenario}"
            f" {group.label()}"
        )


def _stored_places(file: Path) -> Iterator[Array]:
    """Yield the positions (x, y) of all robots after all ticks [m], as one array."""
    table = read_trajectory(file)
    places = np.stack([table["x"].to_numpy(), table["y"].to_numpy()], axis=1)
    yield np.asarray(places[table["t"].to_numpy() > 0.0], np.float64)


def _run(of: ExperimentConfig, setup: str, label: str, seed: int, trips: int | None) -> PathDensity:
    """Run an episode; ConfigError if its round trips differ from `trips`."""
    LOGGER.warning("running %s, %s, seed %d", setup, label, seed)
    loop = Loop(of.scenario, of.controller, [seed], of.physics)

    def places() -> Iterator[Array]:
        for _ in range(of.scenario.n_ticks):
            loop.step()
            yield loop.world.robots["pose"][0, :, :2]

    density = _density(of.scenario, label, places())
    made = int(loop.world.robots["round_trips"].sum())
    if trips is not None and made != trips:
        raise ConfigError(
            f"seed {seed} gives {made} round trips here, but {trips} in the dataset, which was"
            " made with other libraries or on another machine; evaluate into another folder"
        )
    return PathDensity(setup, label, seed, density)


def _density(scenario: Scenario, controller: str, every: Iterable[Array]) -> Density:
    """Return the density of robots in each cell, mean over all ticks, from their positions."""
    size = scenario.arena.length, scenario.arena.width
    n_cells = [max(1, round(side / CELL)) for side in size]
    counts = np.zeros(n_cells)
    for places in every:
        cells = ((places / size + 0.5) * n_cells).astype(np.int64)
        cells = np.clip(cells, 0, np.array(n_cells) - 1)
        np.add.at(counts, (cells[:, 0], cells[:, 1]), 1.0)
    cell_area = size[0] * size[1] / counts.size
    return counts.T / (scenario.n_ticks * cell_area), stage_of(scenario, controller)
