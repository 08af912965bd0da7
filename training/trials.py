"""Candidates for a layer tried out: many networks, many worlds, side by side.

A candidate in a world of a block has the round trips that it has alone, whatever the blocks.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed

from baselines.controller import Recipe
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import ignore_sigint, warm_up
from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.metrics import total
from swarm_forage_env.scenario import Scenario
from training.policy import LayerName
from training.reflexes import Reflexes
from training.weighting import Networks

MAX_ROWS = 2000
"""Robots in a block, about: more rows hardly share Python's cost per tick any further."""


@dataclass(frozen=True)
class Block:
    """Worlds of one scenario that run side by side, each with a candidate."""

    scenario: Scenario
    recipe: Recipe
    physics: str
    networks: Float32[Array, "networks numbers"]
    which: tuple[int, ...]
    """The candidate of each world."""
    seeds: tuple[int, ...]
    """The seed of each world."""
    layer: LayerName
    """What the candidates take the place of."""


@dataclass(frozen=True)
class Trials:
    """Where candidates are tried: scenarios, the rest of the controller, an engine."""

    scenarios: Mapping[str, Scenario]
    recipe: Recipe
    physics: str = "rigid"
    workers: int = 1
    layer: LayerName = "weighting"

    def warm_up(self) -> None:
        """Go through every kernel once, so that workers find them compiled."""
        for name, scenario in self.scenarios.items():
            warm_up(ExperimentConfig(name, scenario, self.recipe, self.physics))

    def round_trips(
        self, networks: Float32[Array, "networks numbers"], seeds: Sequence[int]
    ) -> dict[str, Int64[Array, "networks worlds"]]:
        """Round trips of every candidate under every seed, in each scenario."""
        blocks = {
            name: list(self._blocks(scenario, networks, seeds))
            for name, scenario in self.scenarios.items()
        }
        trips = iter(self._run([block for each in blocks.values() for block in each]))
        shape = len(networks), len(seeds)
        return {
            name: np.concatenate([next(trips) for _ in each]).reshape(shape)
            for name, each in blocks.items()
        }

    def simulated(self, worlds: int) -> float:
        """Simulated time of so many worlds of each scenario [s]."""
        return worlds * sum(each.n_ticks * each.tick for each in self.scenarios.values())

    def _blocks(
        self, scenario: Scenario, networks: Float32[Array, "networks numbers"], seeds: Sequence[int]
    ) -> Iterator[Block]:
        worlds = [(which, seed) for which in range(len(networks)) for seed in seeds]
        room = max(1, MAX_ROWS // scenario.task.n_robots)
        size = min(room, -(-len(worlds) // self.workers))
        for part in np.array_split(np.arange(len(worlds)), -(-len(worlds) // size)):
            which, own_seeds = zip(*(worlds[k] for k in part), strict=True)
            yield Block(scenario, self.recipe, self.physics, networks, which, own_seeds, self.layer)

    def _run(self, blocks: Sequence[Block]) -> list[Int64[Array, " worlds"]]:
        parallel = Parallel(n_jobs=self.workers, return_as="generator", batch_size=1)
        with ignore_sigint():
            finished = parallel(delayed(run_block)(block) for block in blocks)
        with closing(finished):  # ends the workers, whatever happens
            return list(finished)


def run_block(block: Block) -> Int64[Array, " worlds"]:
    """Whole episodes; the round trips of each world."""
    loop = ControlLoop(block.scenario, block.recipe, block.seeds, block.physics)
    of_row = np.repeat(np.array(block.which, np.int64), block.scenario.task.n_robots)
    if block.layer == "weighting":
        loop.controller.weighting = Networks(block.networks, of_row)
    else:
        loop.controller.motion = Reflexes(block.networks, block.scenario, block.seeds, of_row)
    for _ in range(block.scenario.n_ticks):
        loop.step()
    return total(loop.world.state.round_trips, len(block.seeds))
