"""Some worlds of a block are started anew, also under other numbers; the others go on."""

import pytest

from swarm_forage_env import thread_team
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KEEP, REPLACE
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.worlds import run

ENGINES = ("rigid", "kinematic")
BUSY = {"cruise_speed": 0.12, "area_distance": 0.7, "wheel_noise": 0.02, "duration": 60.0}
"""Fast robots and near areas: contacts, exchanges and round trips within a minute."""
OTHER = {**BUSY, "arena.length": 1.4, "arena.width": 1.0, "area_distance": 0.9, "radius": 0.03,
         "axle": 0.06, "max_range": 0.3, "tick": 0.2, "exchange_time": 1.0,
         "faults.liar.share": 0.3}  # fmt: skip
"""Other walls, bodies, ticks, faults and radio: more neighbours, other cells than BUSY has."""
SEEDS = (4, 9, 2)
CONTROLLER = CONTROLLERS["dsgiff"].with_parameters({"beta": 0.1})


def busy(**more):
    return find_scenario("es1", {**BUSY, **more})


@pytest.mark.parametrize("physics", ENGINES)
def test_a_world_reset_under_other_numbers_goes_on_as_the_world_alone(same, physics):
    block, twin = (Loop(busy(), CONTROLLER, SEEDS, physics) for _ in range(2))
    run(250, block, twin)
    other = find_scenario("es1", OTHER)
    near = busy(max_range=0.1, obstacles=({"points": [[0.0, 0.4]], "radius": 0.1},))
    block.reset([7, 21], worlds=[2, 0], scenarios=[near, other])
    small = Loop(near, CONTROLLER, [7], physics)
    alone = Loop(other, CONTROLLER, [21], physics)
    for _ in range(4):
        same(block, 0, alone)
        same(block, 1, twin, 1)
        same(block, 2, small)
        run(100, block, twin, alone, small)
    assert alone.world.robots["messages"].sum() > 0
    assert block.world.scenario is other
    assert block.world.is_over.tolist() == [True, True, False]
    block.reset([5], worlds=[0])
    same(block, 0, Loop(other, CONTROLLER, [5], physics))


@pytest.mark.parametrize(("before", "after"), [(0.05, 0.4), (0.4, 0.05)])
def test_room_for_neighbours_and_cells_grows_with_what_a_world_needs(
    same, monkeypatch, before, after
):
    """A short reach needs more cells, a long one more neighbours; also of a thread that polls."""
    monkeypatch.setattr(thread_team, "polls_for", lambda seconds: 10**6)
    old, new = (find_scenario("es3", {"max_range": reach}) for reach in (before, after))
    block, twin = (Loop(old, CONTROLLER, [1, 2], "kinematic", threads) for threads in (2, 1))
    run(30, block, twin)
    block.reset([3], worlds=[1], scenarios=new)
    alone = Loop(new, CONTROLLER, [3], "kinematic")
    run(60, block, twin, alone)
    same(block, 1, alone)
    same(block, 0, twin)


BAD = {
    "three worlds, one seed": ({"seeds": [1]}, r"seeds=\[1\]: must be 3"),
    "two worlds, one seed": ({"seeds": [1], "worlds": [0, 1]}, r"seeds=\[1\]: must be 2"),
    "a world twice": ({"seeds": [1, 2], "worlds": [0, 0]}, r"worlds=\[0, 0\]: must be a mask"),
    "a world too many": ({"seeds": [1], "worlds": [3]}, r"worlds=\[3\]: .* from 0 to 2"),
    "no seed": ({"seeds": [1, -1], "worlds": [0, 1]}, "seed=-1"),
    "one scenario of two": (
        {"seeds": [1, 2], "worlds": [0, 1], "scenarios": [busy()]}, "1 given for 2 worlds",
    ),
    "more robots": (
        {"seeds": [1, 2], "worlds": [0, 1], "scenarios": [busy(), busy(n_robots=8)]},
        "task.n_robots=8 in the scenario 'es1': the world was made with 10",
    ),
    "fewer slots": (
        {"seeds": [1], "worlds": [0], "scenarios": busy(slots=2)},
        "radio.slots=2 in the scenario 'es1': the world was made with 4",
    ),
    "another task": (
        {"seeds": [1], "worlds": [0], "scenarios": find_scenario("waypoints-05")},
        "'waypoints-05' of the task waypoints",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("how", "why"), BAD.values(), ids=BAD)
def test_what_does_not_fit_is_refused_before_anything_changes(how, why):
    block, twin = (Loop(busy(), CONTROLLER, SEEDS) for _ in range(2))
    run(20, block, twin)
    with pytest.raises(ConfigError, match=why):
        block.reset(**how)
    run(20, block, twin)
    assert block.world.robots.tobytes() == twin.world.robots.tobytes()
    assert block.controller.minds.tobytes() == twin.controller.minds.tobytes()
    assert block.world.scenarios == twin.world.scenarios


def test_a_world_without_room_to_start_is_refused():
    block = Loop(busy(), CONTROLLER, SEEDS)
    block.world.worlds["start_radius"][1] = 0.05
    with pytest.raises(ConfigError, match="world 1: the robots found no place in the start"):
        block.reset([1, 2, 3])


def test_a_blank_block_is_that_of_the_seeds_of_its_first_reset():
    block = Loop(busy(), CONTROLLER, SEEDS, is_blank=True)
    assert not block.world.robots["pose"].any()
    block.reset([7, 2**64 - 1, 9])
    whole = Loop(busy(), CONTROLLER, [7, 2**64 - 1, 9])
    run(20, block, whole)
    assert block.world.robots.tobytes() == whole.world.robots.tobytes()
    assert block.controller.minds.tobytes() == whole.controller.minds.tobytes()


def test_scenarios_of_different_tasks_are_refused():
    scenarios = [find_scenario("es1"), find_scenario("waypoints-05")]
    with pytest.raises(ConfigError, match="must be of one task"):
        Loop(scenarios, CONTROLLER, [0, 1])


def test_a_reset_leaves_what_a_learner_does_with_the_layers(running):
    loop = running("es1", [4, 5])
    loop.world.robots["action"]["motion"][0] = REPLACE
    loop.reset([6, 7])
    assert loop.world.robots["action"]["motion"].tolist() == [[REPLACE] * 10, [KEEP] * 10]
