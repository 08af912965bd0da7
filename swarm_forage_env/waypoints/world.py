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
"""The only engine for a world without contacts."""

SOURCES = (NoiseSource.ENCODER, NoiseSource.LANDMARK, NoiseSource.LIDAR, NoiseSource.GOAL)
"""Noise source of each column of the random streams."""


class WaypointsWorld(World):
    """Worlds in parallel, each with its own seed and parameters, and bit for bit as it is alone."""

    scenarios: tuple[WaypointsScenario, ...]

    def __init__(
        self, scenarios: Sequence[WaypointsScenario], seeds: Sequence[int], physics: str = PHYSICS
    ) -> None:
        """Create one world per scenario and reset it with its seed; there are no readings yet.

        The scenarios have the same number of robots. Without seeds no robot has a pose.
        """
        if physics != PHYSICS:
            raise ConfigError(
                f"physics='{physics}': {scenarios[0].name} has no contacts and runs under"
                f" physics='{PHYSICS}' only"
            )
        super().__init__(scenarios)
        shape = (self.n_worlds, self.n_robots)
        self.robots = RobotState.array(shape)
        """True state of every robot, shape (worlds, robots); writing to it changes the worlds."""
        self.sightings = Sighting.array((*shape, self.n_robots))
        """Sightings, shape (worlds, robots, robots): row i holds what robot i sees."""
        self.worlds = WorldState.array((self.n_worlds,))
        """Clock and parameters of every world."""
        self.replace_scenarios(range(self.n_worlds), scenarios)
        if len(seeds) > 0:
            self.reset(seeds)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Arrays passed to the templates of a tick."""
        return self.robots, self.sightings, self.worlds, self.rewards

    @property
    def functions(self) -> Mapping[str, Kernel]:
        """Functions bound to free names of `run_ticks`."""
        return {"tick_world": tick_world, "move_world": nothing}

    def write_parameters(self, first: int, last: int) -> None:
        """Write the parameters of worlds first .. last - 1, which share one scenario."""
        write_numbers(self.scenarios[first], self.worlds[first:last])

    def restart(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Place the robots at home and seed their random streams."""
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
        """Judge the claims made after the last tick."""
        self.robots["command"]["claim"] = np.reshape(claim, self.robots.shape)
        judge_claims(self.robots, self.worlds)


def write_numbers(scenario: WaypointsScenario, out_worlds: Array | np.void) -> None:
    """Write the parameters of a scenario to the records of its worlds."""
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
