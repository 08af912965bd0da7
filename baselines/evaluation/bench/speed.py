"""Speed of ticks in robot-steps per second, compared with pymunk alone; time shares of stages."""

import statistics
import time
from timeit import Timer

import numpy as np
from pymunk.batch import Buffer, get_space_bodies, set_space_bodies

from baselines.evaluation.bench.cases import Case, Measured, Tick, uniform_poses
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.physics.pymunk_buffers import SUBSTEPS
from swarm_forage_env.physics.rigid import TO_READ, TO_WRITE, space_of
from swarm_forage_env.ticks import STAGES


def bare_pymunk(case: Case) -> Tick:
    """Return a tick of pymunk alone; each starts from the same poses, all over the arena."""
    scenario = case.scenario
    written = _bodies(case)
    spaces = [space_of(scenario) for _ in written]
    buffers = [_buffer(world) for world in written]
    reads = [_buffer(np.zeros(6 * written.shape[1] + 16)) for _ in spaces]

    def tick() -> None:
        for space, buffer, read in zip(spaces, buffers, reads, strict=True):
            set_space_bodies(space, TO_WRITE, buffer)
            for _ in range(SUBSTEPS):
                space.step(scenario.tick / SUBSTEPS)
            read.clear()
            get_space_bodies(space, TO_READ, read)

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


def _buffer(memory: Array) -> Buffer:
    buffer = Buffer()
    buffer.set_float_buf(memory)
    return buffer


REPEATS, LENGTH = (5, 3), (0.5, 0.15)
"""Number of repeats and length of each [s], in a full and a quick run; the median is reported."""


def seconds_per_tick(tick: Tick, quick: bool) -> float:
    """Return the median time of one call [s], over repeats of a fixed length."""
    repeats, length = REPEATS[quick], LENGTH[quick]
    timer = Timer(tick, timer=time.perf_counter)
    timer.timeit(1)
    count = max(3, round(length / max(timer.timeit(3) / 3, 1e-7)))
    return statistics.median(timer.repeat(repeats, count)) / count


def case_speeds(case: Case, quick: bool) -> Measured:
    """Measure robot-steps per second of a block under both engines, and of pymunk alone."""
    rigid = seconds_per_tick(case.tick("rigid", quick), quick)
    kinematic = seconds_per_tick(case.tick("kinematic", quick), quick)
    bare = seconds_per_tick(bare_pymunk(case), quick)
    robot_steps = case.rows * case.n_ticks
    return {
        "case": case.name,
        "rows": case.rows,
        "rigid": robot_steps / rigid,
        "kinematic": robot_steps / kinematic,
        "bare_pymunk": case.rows / bare,
        "rigid_over_bare": rigid / case.n_ticks / bare,
    }


def thread_gain(case: Case, physics: str, threads: int, quick: bool) -> float:
    """Measure the speed-up of a block on several threads, relative to one thread."""
    one = seconds_per_tick(case.tick(physics, quick), quick)
    return one / seconds_per_tick(case.tick(physics, quick, threads), quick)


TICKS, QUICK_TICKS = 600, 100

SHARES = (*STAGES, "rest")
"""Timed parts. `engine` moves bodies that may touch; `tick` moves all others, scores, senses and
receives messages; `rest` is Python around the stages."""


def stage_shares(case: Case, physics: str, quick: bool) -> dict[str, float]:
    """Return each stage's share of the time of a tick; each stage is a separate call."""
    loop = case.start(physics, quick)
    spent = dict.fromkeys(STAGES, 0.0)
    for name in STAGES:  # compiles the stage
        loop.run_stages(name)
    ticks = max(10, (QUICK_TICKS if quick else TICKS) * 100 // max(100, case.rows))
    begin = time.perf_counter()
    for _ in range(ticks):
        for name in STAGES:
            start = time.perf_counter()
            loop.run_stages(name)
            spent[name] += time.perf_counter() - start
    wall = time.perf_counter() - begin
    shares = {name: seconds / wall for name, seconds in spent.items()}
    return shares | {"rest": max(0.0, 1.0 - sum(shares.values()))}
