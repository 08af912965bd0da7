"""Wheels integrated exactly, no forces: fast, and the engine of worlds without contacts."""

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.kernels.diff_drive import drive
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.physics.base import ENGINES
from swarm_forage_env.scenario import Scenario


@ENGINES.register("kinematic")
class Kinematic:
    """Every robot goes where its wheels take it."""

    def __init__(self, scenario: Scenario, n_worlds: int) -> None:
        """Robots of this scenario."""
        self._dt = scenario.tick
        self._axle = scenario.robot.axle

    def move(
        self,
        pose: Float64[Array, "rows 3"],
        wheels: Float64[Array, "rows 2"],
        neighbours: Neighbours,
    ) -> None:
        """Advance the poses by one tick, in place."""
        drive(pose, wheels, self._dt, self._axle)

    def reset(self, world: int) -> None:
        """There is nothing to forget."""
