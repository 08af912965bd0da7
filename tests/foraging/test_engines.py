"""Engines and ticks: who moves robots and how fast, and what a layer was shown."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env.compiler import bind
from swarm_forage_env.physics.base import ENGINES
from swarm_forage_env.physics.kinematic import Kinematic
from swarm_forage_env.physics.pymunk_buffers import SUBSTEPS
from swarm_forage_env.physics.rigid import Rigid
from swarm_forage_env.ticks import only, run_ticks


def moved_by_pymunk(space, bodies, dt):
    """Where a tick of a space takes its bodies, without a compiled function."""
    for body, (x, y, angle, vx, vy, spin) in zip(space.bodies, bodies.tolist(), strict=False):
        body.position, body.angle = (x, y), angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    for _ in range(SUBSTEPS):
        space.step(dt / SUBSTEPS)
    return [[*body.position, body.angle] for body in space.bodies]


def test_rigid_moves_robots_as_pymunk_moves_bodies(running):
    world = running("es1", [3], "rigid", start_radius=0.15).world
    engine, rng, touching = world._physics, np.random.default_rng(4), 0
    (space,) = Rigid(world.scenarios)._spaces.values()
    move = bind(run_ticks, {**world.functions, **only("engine")})
    for _ in range(100):
        world.worlds["has_moved"] = False
        world.robots["command"]["wheels"] = rng.uniform(-1.0, 1.0, (1, world.n_robots, 2))
        move(world.arrays, (), world.modes, world.errors, 0, 1, 1)
        if world.worlds["has_moved"]:
            poses = moved_by_pymunk(space, engine._memory["written"][0], world.scenario.tick)
            assert_array_equal(engine._memory["read"][0, : world.n_robots], poses)
            touching += len(space._get_arbiters())
    assert touching > 50


class Pushed(Kinematic):
    """Moves every robot by a millimetre along x before each tick."""

    def move(self, robots, worlds, near, obstacles, first, last):
        robots["pose"][first:last, :, 0] += 0.001


def test_an_engine_with_a_method_move_moves_the_robots_before_each_tick(running, monkeypatch):
    monkeypatch.setitem(ENGINES._parts, "pushed", Pushed)
    usual, pushed = (running("near", [0], name) for name in ("kinematic", "pushed"))
    for loop in (usual, pushed):
        loop.run(2)
    away = pushed.world.robots["pose"] - usual.world.robots["pose"]
    assert_allclose(away[0], np.tile([0.002, 0.0, 0.0], (5, 1)), atol=1e-9)


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_the_motors_go_no_faster_than_they_can_whatever_is_commanded(running, go, physics):
    world = running("es1", [0], physics, n_robots=1).world
    world.state.pose[:] = 0.0
    state = go(world, 5.0, speaking=True)
    assert_allclose(state.command.wheels, 5.0 / 0.06)
    assert state.command.is_speaking.all()
    assert_allclose(state.pose[0, :2], [0.0129, 0.0], atol=1e-12)
    assert_allclose(state.wheels, 0.129)


def test_what_a_layer_was_shown_is_not_changed_by_the_next_tick(running):
    loop = running("es1", [0], duration=60.0, cruise_speed=0.12, area_distance=0.7)
    loop.run(300)
    shown = [loop.situation, loop.exchange]
    before = [each.copy() for each in shown]
    loop.run(50)
    assert loop.situation.tobytes() != before[0].tobytes()
    for each, was in zip(shown, before, strict=True):
        assert each.tobytes() == was.tobytes()
