"""The world of patrol: its records, its tick, and a block of worlds."""

import math

import numpy as np

from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.equations.differential_drive import advance, wheels_to_arc
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.equations.random_draws import normal, symmetric
from swarm_forage_env.random_streams import NoiseSource, streams
from swarm_forage_env.record import Record, field
from swarm_forage_env.task import World
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import nothing

PLACE, SENSOR = range(2)
"""Columns of a robot's random streams."""

N_PLACES = 3


class WorldState(Record):
    """One world: its clock, and the numbers of its scenario."""

    ticks = field(np.int64)
    tick = field(np.float64, unit="s")
    speed = field(np.float64, unit="m/s")
    axle = field(np.float64, unit="m")
    noise = field(np.float64, unit="m")
    distance = field(np.float64, unit="m")
    radius = field(np.float64, unit="m")


class Readings(Record):
    """What a robot senses: the next place, in its body frame, with noise."""

    place = field(np.float32, 2, unit="m")


class Command(Record):
    """What a robot is told to do."""

    wheels = field(np.float32, 2, unit="of full speed")


class Action(Record):
    """What a learner does with the motion of a robot."""

    motion = field(np.int8)
    wheels = field(np.float32, 2, unit="of full speed", low=-1.0, high=1.0, names=("lr",))


class RobotState(Record):
    """The truth about one robot, and what it senses and does."""

    pose = field(np.float64, 3, unit="m, m, rad")
    streams = field(np.uint64, 2)
    goal = field(np.int64)
    visits = field(np.int32)
    reward = field(np.float32)
    readings = field(Readings)
    command = field(Command)
    action = field(Action)


@kernel
def way(robot, world):
    """From a robot to its next place, world frame [m]."""
    angle = 2.0 * math.pi * robot.goal / N_PLACES
    x, y = world.distance * math.cos(angle), world.distance * math.sin(angle)
    return x - robot.pose[0], y - robot.pose[1]


@kernel
def sense(robot, world):
    """The next place as the robot sees it."""
    dx, dy = way(robot, world)
    ahead, left = to_body(dx, dy, math.cos(robot.pose[2]), math.sin(robot.pose[2]))
    robot.readings.place[0] = ahead + world.noise * normal(robot.streams, SENSOR)
    robot.readings.place[1] = left + world.noise * normal(robot.streams, SENSOR)


@kernel
def drive(robot, world):
    """Move as commanded, and reach the next place or not."""
    pose, step = robot.pose, world.speed * world.tick
    wheels = robot.command.wheels
    distance, turn = wheels_to_arc(step * wheels[0], step * wheels[1], world.axle)
    pose[0], pose[1], pose[2] = advance(pose[0], pose[1], pose[2], distance, turn)
    robot.reward = 0.0
    dx, dy = way(robot, world)
    if math.hypot(dx, dy) < world.radius:
        robot.visits += 1
        robot.reward = 1.0
        robot.goal = (robot.goal + 1) % N_PLACES


@row_template
def tick_world(world_arrays, errors, w, n, n_moving):
    """One tick of the n robots of a world; where none are moving it begins, and all sense only."""
    robots, worlds, rewards = world_arrays
    if n_moving > 0:
        worlds[w].ticks += 1
    for i in range(n_moving):
        drive(robots[w, i], worlds[w])
        rewards[w, i] += robots[w, i].reward
    for i in range(n):
        sense(robots[w, i], worlds[w])


@entry_point
def start(robots, which):
    """Place the robots of one world about the origin."""
    for i in range(robots.shape[1]):
        for k in range(3):
            robots[which, i].pose[k] = 0.1 * symmetric(robots[which, i].streams, PLACE)


class PatrolWorld(World):
    """A block of worlds, each from its own seed."""

    def __init__(self, scenarios, seeds, physics):
        super().__init__(scenarios)
        self.robots = RobotState.array((self.n_worlds, self.n_robots))
        self.worlds = WorldState.array((self.n_worlds,))
        self.replace_scenarios(range(self.n_worlds), scenarios)
        if len(seeds) > 0:
            self.reset(seeds)

    @property
    def arrays(self):
        return self.robots, self.worlds, self.rewards

    @property
    def functions(self):
        return {"tick_world": tick_world, "move_world": nothing}

    def write_parameters(self, first, last):
        world, scenario = self.worlds[first:last], self.scenarios[first]
        for name in ("tick", "speed", "axle", "noise"):
            world[name] = getattr(scenario, name)
        world["distance"], world["radius"] = scenario.task.distance, scenario.task.radius

    def restart(self, first, last, seeds):
        swarms = self.robots[first:last]
        kept = swarms["action"].copy()
        RobotState.restart(swarms)
        swarms["action"], self.worlds["ticks"][first:last] = kept, 0
        for column, source in enumerate((NoiseSource.PLACE, NoiseSource.LANDMARK)):
            words = streams(seeds, self.n_robots, source)
            swarms["streams"][:, :, column] = words.reshape(swarms.shape)
        for which in range(first, last):
            start(self.robots, which)
