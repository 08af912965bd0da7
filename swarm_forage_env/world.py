"""World: W worlds of N robots, and the straight line of one tick.

move -> settle -> score -> sense -> listen
"""

from collections.abc import Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Command, Feedback, Heard, Readings
from swarm_forage_env.kernels.compiler import announce
from swarm_forage_env.kernels.neighbours import push_apart
from swarm_forage_env.kernels.task import place_in_circle, score
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.sensors.ground import Ground
from swarm_forage_env.sensors.odometry import Odometry
from swarm_forage_env.sensors.proximity import Proximity
from swarm_forage_env.sensors.radio import RadioBoard
from swarm_forage_env.state import empty_state
from swarm_forage_env.streams import Cause, checked_seed, streams

OVERLAP = 1e-4
"""Overlap of two bodies left standing after contacts are settled [m]."""

WORLD_CAUSES = (
    Cause.ENCODER,
    Cause.PROXIMITY,
    Cause.GROUND,
    Cause.LOSS,
    Cause.SLOT,
    Cause.RADIO,
)


class World:
    """A block of worlds that run side by side under one scenario, each from its own seed.

    A world in a block goes through the same states as the same world alone, bit for bit.
    """

    def __init__(
        self, scenario: Scenario, seeds: Sequence[int] = (0,), physics: str = "rigid"
    ) -> None:
        """One world for each seed, reset and ready; `feedback` holds what the robots sense."""
        announce()
        self.scenario = scenario
        self.n_worlds = len(seeds)
        self.n_robots = scenario.task.n_robots
        self.rows = self.n_worlds * self.n_robots
        self.state = empty_state(self.n_worlds, self.n_robots)
        self.areas = scenario.areas
        self._physics = ENGINES[physics](scenario, self.n_worlds)
        self._proximity = Proximity(scenario, self.rows)
        self._ground = Ground(scenario)
        self._odometry = Odometry(scenario)
        self._radio = RadioBoard(scenario, self.rows)
        reach = max(self._proximity.reach, self._radio.reach)
        self.neighbours = Neighbours(scenario, self.n_worlds, reach)
        self.streams = {cause: np.zeros(self.rows, np.uint64) for cause in WORLD_CAUSES}
        self._settled: Bool[Array, " worlds"] = np.zeros(self.n_worlds, np.bool_)
        for world, seed in enumerate(seeds):
            self._restart(world, seed)
        self.feedback = self._first_feedback()

    def reset(self, seeds: Sequence[int]) -> Feedback:
        """Start every world anew, each from its seed; what the robots sense before moving."""
        if len(seeds) != self.n_worlds:
            raise ConfigError(f"seeds={list(seeds)}: must be {self.n_worlds}, one for each world")
        for world, seed in enumerate(seeds):
            self._restart(world, seed)
        self.feedback = self._first_feedback()
        return self.feedback

    def tick(self, command: Command) -> Feedback:
        """Carry out one command: everyone moves, is scored, senses and hears."""
        state, limit = self.state, self.scenario.robot.max_speed
        np.clip(command.wheels, -limit, limit, out=state.wheels)  # as far as the motors go
        self._physics.move(state.pose, state.wheels, self.neighbours)
        self._settle()
        state.ticks[:] += 1
        state.known[:] = command.known
        reward = self._score(command.lost)
        readings = self._sense()
        state.words[:] = command.words
        state.speaking[:] = command.speaking
        heard = self._radio(state, self.neighbours, self.streams)
        done = state.ticks >= self.scenario.n_ticks
        self.feedback = Feedback(readings, heard, reward, done)
        return self.feedback

    def _settle(self) -> None:
        """Find the neighbours, and push apart what the engine left overlapping."""
        self.neighbours.find(self.state.pose)
        push_apart(
            self.neighbours.pairs,
            self.neighbours.start,
            self.neighbours.arena,
            self.scenario.robot.radius,
            OVERLAP,
            self.state.pose,
            self._settled,
        )

    def _score(self, lost: Bool[Array, " rows"]) -> Float32[Array, " rows"]:
        """Book visits, round trips and lost reports; the round trips completed in this tick."""
        state, scenario = self.state, self.scenario
        reward = np.empty(self.rows, np.float32)
        score(
            state.pose,
            lost,
            state.known,
            self.areas,
            scenario.task.area_radius,
            scenario.sensors.ground_ahead,
            scenario.n_ticks // 2,
            state.ticks,
            state.leg,
            state.round_trips,
            state.first_visit,
            state.path_ticks,
            state.lost_events,
            reward,
        )
        return reward

    def _sense(self) -> Readings:
        """What the robots' own sensors read."""
        return Readings(
            proximity=self._proximity(self.state, self.neighbours, self.streams),
            ground=self._ground(self.state, self.streams),
            odometry=self._odometry(self.state, self.streams),
        )

    def _restart(self, world: int, seed: int) -> None:
        """Put one world's robots at their starting places and its streams at their seed."""
        seed = checked_seed(seed)
        rows = slice(world * self.n_robots, (world + 1) * self.n_robots)
        for cause, words in self.streams.items():
            words[rows] = streams([seed], self.n_robots, cause)
        self._physics.reset(world)
        fresh = empty_state(1, self.n_robots)
        places = streams([seed], self.n_robots, Cause.PLACE)
        task, diameter = self.scenario.task, 2.0 * self.scenario.robot.radius
        placed = place_in_circle(task.start_radius, diameter, places, fresh.pose)
        if placed < self.n_robots:
            raise ConfigError(
                f"task.n_robots={self.n_robots}: only {placed} found a place in the start circle of"
                f" radius {task.start_radius} m; enlarge task.start_radius"
            )
        for name in fresh.__slots__:
            where = slice(world, world + 1) if name == "ticks" else rows
            getattr(self.state, name)[where] = getattr(fresh, name)

    def _first_feedback(self) -> Feedback:
        """What is sensed before the first tick; nobody has spoken yet."""
        self.neighbours.find(self.state.pose)
        silence: Heard = self._radio.silence()
        nothing = np.zeros(self.rows, np.float32)
        return Feedback(self._sense(), silence, nothing, np.zeros(self.n_worlds, np.bool_))
