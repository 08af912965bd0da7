"""WaypointsWorld: W worlds of N robots that visit goals, and the straight line of one tick.

judge claims -> drive -> sense -> see each other
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int32, Int64, checked
from swarm_forage_env.compiler import announce
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.random_streams import Cause, checked_seed, streams
from swarm_forage_env.scenario import record
from swarm_forage_env.waypoints.dynamics import (
    draw_devices,
    drive_within_limits,
    fix_at_home,
    judge_claims,
    measure_motion,
    place_at_home,
    see_each_other,
)
from swarm_forage_env.waypoints_interface import (
    Sightings,
    WaypointCommand,
    WaypointFeedback,
    WaypointReadings,
)
from swarm_forage_env.waypoints_scenario import WaypointsScenario

WORLD_CAUSES = (Cause.ENCODER, Cause.LANDMARK, Cause.LIDAR, Cause.GOAL)

PHYSICS = "kinematic"
"""The one engine of a world without contacts."""


@checked
@dataclass(frozen=True, slots=True)
class WaypointsState:
    """What is true in W worlds of N robots. Controllers never see it."""

    pose: Float64[Array, "rows 3"]
    """x, y [m] and heading [rad], home at the origin. Writer: drive; at reset, the scenario."""

    motion: Float64[Array, "rows 2"]
    """Speed [m/s] and turn rate [rad/s] of the last tick. Writer: drive."""

    goal: Float64[Array, "rows 2"]
    """Where each robot is to go [m]. Writer: judge."""

    deviation: Float64[Array, "rows 2"]
    """Standard deviation of the readings of speed and turn rate. Writer: the scenario at reset."""

    bias: Float64[Array, "rows 2"]
    """Their constant error. Writer: the scenario at reset."""

    right: Int32[Array, " rows"]
    """Goals claimed and reached. Writer: judge."""

    wrong: Int32[Array, " rows"]
    """Goals claimed and not reached. Writer: judge."""

    ticks: Int64[Array, " worlds"]
    """Ticks since reset. Writer: WaypointsWorld.tick."""


class WaypointsWorld:
    """A block of worlds that run side by side under one scenario, each from its own seed.

    A world in a block goes through the same states as the same world alone, bit for bit.
    """

    def __init__(
        self, scenario: WaypointsScenario, seeds: Sequence[int] = (0,), physics: str = PHYSICS
    ) -> None:
        """One world for each seed, reset and ready; `feedback` holds what the robots sense."""
        announce()
        if physics != PHYSICS:
            raise ConfigError(
                f"physics='{physics}': {scenario.name} has no contacts; only '{PHYSICS}' drives it"
            )
        self.scenario = scenario
        self.n_worlds = len(seeds)
        self.n_robots = n = scenario.task.n_robots
        self.rows = rows = self.n_worlds * n
        self.state = WaypointsState(
            pose=np.zeros((rows, 3)),
            motion=np.zeros((rows, 2)),
            goal=np.zeros((rows, 2)),
            deviation=np.zeros((rows, 2)),
            bias=np.zeros((rows, 2)),
            right=np.zeros(rows, np.int32),
            wrong=np.zeros(rows, np.int32),
            ticks=np.zeros(self.n_worlds, np.int64),
        )
        self.streams = {cause: np.zeros(rows, np.uint64) for cause in WORLD_CAUSES}
        self._limits = record(**scenario.robot.model_dump())
        self.feedback = self.reset(seeds)

    def reset(self, seeds: Sequence[int]) -> WaypointFeedback:
        """Start every world anew, each from its seed; robots begin with an exact fix."""
        if len(seeds) != self.n_worlds:
            raise ConfigError(f"seeds={list(seeds)}: must be {self.n_worlds}, one for each world")
        for world, seed in enumerate(seeds):
            self._restart(world, checked_seed(seed))
        everybody = np.ones(self.rows, np.bool_)
        still = np.zeros((self.rows, 2), np.float32)
        fix = self.state.pose.astype(np.float32)
        readings = self._readings(still, everybody, fix)
        nothing = np.zeros(self.rows, np.float32)
        over = np.zeros(self.n_worlds, np.bool_)
        self.feedback = WaypointFeedback(readings, self._sightings(), nothing, over)
        return self.feedback

    def tick(self, command: WaypointCommand) -> WaypointFeedback:
        """Carry out one command: claims are judged, everyone moves, senses and sees."""
        state, scenario = self.state, self.scenario
        reward = self.judge(command.claim)
        drive_within_limits(command.pull, self._limits, scenario.tick, state.pose, state.motion)
        state.ticks[:] += 1
        motion = np.empty((self.rows, 2), np.float32)
        measure_motion(
            state.motion, state.deviation, state.bias, self.streams[Cause.ENCODER], motion
        )
        at_home, fix = np.empty(self.rows, np.bool_), np.empty((self.rows, 3), np.float32)
        sensors, landmark = scenario.sensors, self.streams[Cause.LANDMARK]
        fix_at_home(state.pose, sensors.reach, sensors.home_noise, landmark, at_home, fix)
        done = state.ticks >= scenario.n_ticks
        readings = self._readings(motion, at_home, fix)
        self.feedback = WaypointFeedback(readings, self._sightings(), reward, done)
        return self.feedback

    def judge(self, claim: Bool[Array, " rows"]) -> Float32[Array, " rows"]:
        """Book claims and hand out new goals; goals rightly claimed by each robot.

        Those of a tick are judged in the next; after the last tick, call it once more.
        """
        state, task = self.state, self.scenario.task
        reward = np.empty(self.rows, np.float32)
        judge_claims(
            claim, state.pose, task.tolerance, 0.5 * task.side, self.streams[Cause.GOAL],
            state.goal, state.right, state.wrong, reward,
        )  # fmt: skip
        return reward

    def _readings(
        self,
        motion: Float32[Array, "rows 2"],
        at_home: Bool[Array, " rows"],
        fix: Float32[Array, "rows 3"],
    ) -> WaypointReadings:
        return WaypointReadings(
            motion=motion,
            compass=self.state.pose[:, 2].astype(np.float32),
            at_home=at_home,
            fix=fix,
            goal=self.state.goal.astype(np.float32),
        )

    def _sightings(self) -> Sightings:
        shape, sensors = (self.rows, self.n_robots), self.scenario.sensors
        found = Sightings(
            seen=np.empty(shape, np.bool_),
            range=np.empty(shape, np.float32),
            bearing=np.empty(shape, np.float32),
        )
        see_each_other(
            self.state.pose, self.n_robots, sensors.reach, sensors.range_noise,
            sensors.bearing_noise, self.streams[Cause.LIDAR],
            found.seen, found.range, found.bearing,
        )  # fmt: skip
        return found

    def _restart(self, world: int, seed: int) -> None:
        """Put one world's robots at their starting places and its streams at their seed."""
        n, scenario, state = self.n_robots, self.scenario, self.state
        rows = slice(world * n, (world + 1) * n)
        for cause, words in self.streams.items():
            words[rows] = streams([seed], n, cause)
        task, sensors = scenario.task, scenario.sensors
        place_at_home(
            task.start_half_side, task.first_goal, 0.5 * task.side,
            streams([seed], n, Cause.PLACE), self.streams[Cause.GOAL][rows],
            state.pose[rows], state.goal[rows],
        )  # fmt: skip
        noise = np.array([sensors.speed_noise, sensors.turn_noise])
        bias = np.array([sensors.speed_bias, sensors.turn_bias])
        devices = streams([seed], n, Cause.DEVICE)
        draw_devices(noise, bias, sensors.spread, devices, state.deviation[rows], state.bias[rows])
        state.motion[rows] = scenario.robot.max_speed, 0.0
        state.right[rows] = 0
        state.wrong[rows] = 0
        state.ticks[world] = 0
