"""Speed in robot-steps per second, of ticks, of bare pymunk, on threads; shares of the stages."""

import statistics
import time

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from baselines.evaluation.bench.cases import Case, Measured, Tick, uniform_poses
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.physics.pymunk_buffers import SUBSTEPS
from swarm_forage_env.physics.rigid import FRICTION, MASS
from swarm_forage_env.ticks import STAGES

POSE = BodyFields.POSITION | BodyFields.ANGLE
POSE_AND_VELOCITY = POSE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY


def bare_pymunk(case: Case) -> Tick:
    """Make a function that runs one tick of pymunk alone for a block of worlds.

    The robots are all over the arena and drive at random; every tick starts at the same
    places, every world is stepped, and overlaps stay as pymunk leaves them.
    """
    scenario = case.scenario
    written = _bodies(case)
    spaces = [_space(scenario, world[:, :2]) for world in written]
    buffers = [_buffer(world) for world in written]
    reads = [_buffer(np.zeros(6 * written.shape[1] + 16)) for _ in spaces]

    def tick() -> None:
        for space, buffer, read in zip(spaces, buffers, reads, strict=True):
            set_space_bodies(space, POSE_AND_VELOCITY, buffer)
            for _ in range(SUBSTEPS):
                space.step(scenario.tick / SUBSTEPS)
            read.clear()
            get_space_bodies(space, POSE, read)

    return tick


def _bodies(case: Case) -> Float64[Array, "worlds bodies 6"]:
    """Position, angle, velocity and turn rate of each body; the walls' body comes last."""
    robot, n_robots = case.scenario.robot, case.scenario.task.n_robots
    rng = np.random.default_rng(1)
    wheels = rng.uniform(-robot.cruise_speed, robot.cruise_speed, (case.n_worlds, n_robots, 2))
    speed, pose = wheels.mean(axis=2), uniform_poses(case.scenario, case.n_worlds)
    bodies = np.zeros((case.n_worlds, n_robots + 1, 6))
    bodies[:, :n_robots, :3] = pose
    heading = bodies[:, :n_robots, 2]
    bodies[:, :n_robots, 3] = speed * np.cos(heading)
    bodies[:, :n_robots, 4] = speed * np.sin(heading)
    bodies[:, :n_robots, 5] = (wheels[..., 1] - wheels[..., 0]) / robot.axle
    return bodies


def _space(scenario: Scenario, places: Float64[Array, "bodies 2"]) -> pymunk.Space:
    """A space with robots at their places: at one place, each would be paired with each."""
    space = pymunk.Space()
    for number in range(scenario.task.n_robots):
        radius = scenario.robot.radius
        body = pymunk.Body(MASS, pymunk.moment_for_circle(MASS, 0.0, radius))
        body.position = tuple(places[number].tolist())
        shape = pymunk.Circle(body, radius)
        shape.friction = FRICTION
        space.add(body, shape)
    x, y = 0.5 * scenario.arena.length, 0.5 * scenario.arena.width
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    walls = zip(corners, corners[1:] + corners[:1], strict=True)
    space.add(*(pymunk.Segment(space.static_body, a, b, 0.0) for a, b in walls))
    return space


def _buffer(memory: Array) -> Buffer:
    buffer = Buffer()
    buffer.set_float_buf(memory)
    return buffer


REPEATS, LENGTH = 5, 0.5
"""How often a measure is repeated, and about how long each takes [s]; the median counts."""

QUICK_REPEATS, QUICK_LENGTH = 3, 0.15


def seconds_per_tick(tick: Tick, quick: bool) -> float:
    """Median time of one tick [s], over repeats of as many ticks as fill a fixed time."""
    repeats, length = (QUICK_REPEATS, QUICK_LENGTH) if quick else (REPEATS, LENGTH)
    tick()
    count = max(3, round(length / max(_timed(tick, 3), 1e-7)))
    return statistics.median(_timed(tick, count) for _ in range(repeats))


def case_speeds(case: Case, quick: bool) -> Measured:
    """Robot-steps per second of a block under both engines, and of bare pymunk."""
    rigid = seconds_per_tick(case.tick("rigid", quick), quick)
    kinematic = seconds_per_tick(case.tick("kinematic", quick), quick)
    bare = seconds_per_tick(bare_pymunk(case), quick)
    return {
        "case": case.name,
        "rows": case.rows,
        "rigid": case.robot_steps / rigid,
        "kinematic": case.robot_steps / kinematic,
        "bare_pymunk": case.rows / bare,
        "rigid_over_bare": rigid / case.n_ticks / bare,
    }


def thread_gain(case: Case, physics: str, threads: int, quick: bool) -> float:
    """How much faster a block is on several threads than on one."""
    one, several = (
        seconds_per_tick(case.tick(physics, quick, each), quick) for each in (1, threads)
    )
    return one / several


def _timed(tick: Tick, count: int) -> float:
    """Mean time of a tick over `count` of them [s]."""
    start = time.perf_counter()
    for _ in range(count):
        tick()
    return (time.perf_counter() - start) / count


TICKS, QUICK_TICKS = 600, 100

SHARES = (*STAGES, "rest")
"""engine: what moves bodies that may touch, before the tick, which moves all others, scores, senses
and lets hear; rest: Python around the stages."""


def stage_shares(case: Case, physics: str, quick: bool) -> dict[str, float]:
    """Share of a tick's time that each stage takes, where each is a call of its own."""
    loop = case.start(physics, quick)
    spent = dict.fromkeys(STAGES, 0.0)
    for name in STAGES:  # compiles it
        loop.run_stages(name)
    ticks = max(10, (QUICK_TICKS if quick else TICKS) * 100 // max(100, case.rows))
    begin = time.perf_counter()
    for _ in range(ticks):
        for name in STAGES:
            start = time.perf_counter()
            loop.run_stages(name)
            spent[name] += time.perf_counter() - start
    whole = time.perf_counter() - begin
    shares = {name: seconds / whole for name, seconds in spent.items()}
    return shares | {"rest": max(0.0, 1.0 - sum(shares.values()))}
