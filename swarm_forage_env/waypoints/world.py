"""WaypointsWorld: a block of worlds in which robots visit waypoints, as structured arrays."""

from collections.abc import Mapping, Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.parameters import numbers_named
from swarm_forage_env.random_streams import NoiseSource, streams
from swarm_forage_env.task import World
from swarm_forage_env.ticks import nothing
from swarm_forage_env.waypoints.records import RobotState, Sighting, WorldState
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.tick import judge_claims, start_at_home, tick_world

PHYSICS = "kinematic"
"""The one engine of a world without contacts."""

SOURCES = (NoiseSource.ENCODER, NoiseSource.LANDMARK, NoiseSource.LIDAR, NoiseSource.GOAL)
"""What each column of a robot's streams is for."""


class WaypointsWorld(World):
    """Worlds that run side by side, each from its own seed and under its own numbers.

    A world in a block goes through the same states as the same world alone, bit for bit.
    """

    scenarios: tuple[WaypointsScenario, ...]

    def __init__(
        self, scenarios: Sequence[WaypointsScenario], seeds: Sequence[int], physics: str = PHYSICS
    ) -> None:
        """One world for each scenario, whose robots start from its seed: nobody has sensed yet.

        The scenarios have the same number of robots. Without seeds nobody has a place.
        """
        if physics != PHYSICS:
            raise ConfigError(
                f"physics='{physics}': {scenarios[0].name} has no contacts; only '{PHYSICS}'"
                " drives it"
            )
        super().__init__(scenarios)
        shape = (self.n_worlds, self.n_robots)
        self.robots = RobotState.array(shape)
        """The truth about every robot; writing to it changes the worlds."""
        self.sightings = Sighting.array((*shape, self.n_robots))
        """Who sees whom: for every robot a row of those of its world."""
        self.worlds = WorldState.array((self.n_worlds,))
        """Clock and numbers of every world."""
        self.replace_scenarios(range(self.n_worlds), scenarios)
        if len(seeds) > 0:
            self.reset(seeds)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What the templates of a tick are handed."""
        return self.robots, self.sightings, self.worlds, self.earned

    @property
    def functions(self) -> Mapping[str, Kernel]:
        """What `run_ticks` has free names for."""
        return {"tick_world": tick_world, "move_world": nothing}

    def write_parameters(self, first: int, last: int) -> None:
        """Write the numbers of these worlds' scenario."""
        write_numbers(self.scenarios[first], self.worlds[first:last])

    def restart(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Put the robots at home with an exact fix, and their streams at the seeds."""
        swarms, worlds = self.robots[first:last], self.worlds[first:last]
        actions = swarms["action"].copy()
        RobotState.restart(swarms)
        swarms["action"], worlds["ticks"] = actions, 0
        *own, places, devices = (
            streams(seeds, self.n_robots, source).reshape(swarms.shape)
            for source in (*SOURCES, NoiseSource.PLACE, NoiseSource.DEVICE)
        )
        swarms["streams"] = np.stack(own, axis=2)
        start_at_home(swarms, worlds, places, devices)

    def judge(self, claim: Bool[Array, " rows"]) -> None:
        """Book the claims of the last tick, which no tick is left to judge."""
        self.robots["command"]["claim"] = np.reshape(claim, self.robots.shape)
        judge_claims(self.robots, self.worlds)


def write_numbers(scenario: WaypointsScenario, out_worlds: Array | np.void) -> None:
    """Write the numbers of a scenario to the records of its worlds, as kernels read them."""
    sensors, task = scenario.sensors, scenario.task
    numbers = {
        **numbers_named(scenario, WorldState.fields),
        "dt": scenario.tick,
        "noise": (sensors.speed_noise, sensors.turn_noise),
        "bias": (sensors.speed_bias, sensors.turn_bias),
        "half_side": 0.5 * task.side,
    }
    for name, value in numbers.items():
        out_worlds[name] = value
