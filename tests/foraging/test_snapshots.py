"""A snapshot, a copy and a pickle of a running block go on from the same tick, bit for bit."""

import copy
import pickle
import time

import numpy as np
import pymunk
import pytest
from numpy.testing import assert_array_equal

from baselines.controller import LayeredController
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario
from tests.foraging import conftest
from tests.outside import OutsideMotionPart
from tests.scripts import run_python
from tests.worlds import check_each_is_itself, run

ENGINES = ("rigid", "kinematic")
CROWD = {**conftest.CROWD, "cruise_speed": 0.12}
CONTROLLER = CONTROLLERS["dsgiff"].with_parameters({"beta": 0.1})


def crowd(seeds=(3, 1, 2), physics="rigid", controller=CONTROLLER, threads=1, **numbers):
    return Loop(find_scenario("es1", CROWD | numbers), controller, seeds, physics, threads)


@pytest.mark.parametrize("physics", ENGINES)
def test_a_snapshot_is_restored_in_another_block(bits, physics):
    loop, other = crowd(physics=physics), crowd((7, 8, 9), physics)
    run(150, loop)
    run(20, other)
    minds, robots = other.controller.minds, other.world.robots
    other.restore(pickle.loads(pickle.dumps(loop.snapshot())))
    assert other.controller.minds is minds
    assert other.world.robots is robots
    run(100, loop, other)
    assert bits(loop) == bits(other)
    for each in (loop, other):
        each.reset([5], worlds=[1])
    run(50, loop, other)
    assert bits(loop) == bits(other)


@pytest.mark.parametrize("physics", ENGINES)
def test_a_snapshot_brings_back_the_numbers_of_its_worlds(bits, physics):
    loop = crowd((3, 1), physics)
    scenarios = loop.world.scenarios
    run(50, loop)
    kept, twin = loop.snapshot(), copy.deepcopy(loop)
    wall = {"points": [[-0.4, 0.4], [0.4, 0.4]], "radius": 0.01}
    wide = find_scenario(
        "es1", {"n_robots": 15, "max_range": 0.3, "radius": 0.03, "obstacles": [wall]}
    )
    loop.reset([5], worlds=[0], scenarios=wide)
    run(50, loop)
    changed, late = loop.snapshot(), copy.deepcopy(loop)
    loop.restore(kept)
    assert loop.world.scenarios == scenarios
    run(100, loop, twin)
    assert bits(loop) == bits(twin)
    loop.restore(changed)
    run(100, loop, late)
    assert bits(loop) == bits(late)


IN_NUMPY = OutsideMotionPart(SubsumptionParameters())
CONTROLLED = {
    "a motion in NumPy that remembers and draws": LayeredController(
        "numpy", CONTROLLER.estimator, CONTROLLER.weighting, IN_NUMPY
    ),
    **{name: REFERENCES[name] for name in REFERENCES},
    "a filter that keeps something of each pair": find_controller(
        "decentralised_ekf+filter+subsumption"
    ),
}


@pytest.mark.parametrize("controller", CONTROLLED.values(), ids=CONTROLLED)
def test_every_kind_of_controller_goes_on_from_a_copy_and_a_snapshot(controller):
    check_each_is_itself(find_scenario("es1", CROWD), controller, [3, 1, 2])


GO_ON = """
import pickle, sys
with open(sys.argv[1], "rb") as file:
    loop = pickle.load(file)
loop.run(50)
print(loop.world.robots["pose"].tobytes().hex())
"""


def test_a_pickle_goes_on_in_another_process(tmp_path):
    loop, file = crowd(controller=REFERENCES["oracle-weighting"]), tmp_path / "loop.pickle"
    run(100, loop)
    file.write_bytes(pickle.dumps(loop))
    run(50, loop)
    assert run_python("-c", GO_ON, file) == loop.world.robots["pose"].tobytes().hex()


def test_many_spaces_are_restored_and_forgotten():
    """What a space was restored from lies in memory for as long as the space."""
    loop = crowd()
    run(100, loop)
    kept = loop.snapshot()
    for _ in range(50):
        loop.restore(kept)
        run(5, loop)
        loop.reset([1, 2, 3])
        run(5, loop)


OF_ANOTHER_KIND = r"the snapshot of the task foraging, engine .*: cannot be restored"


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"physics": "kinematic"}, OF_ANOTHER_KIND),
        ({"seeds": (3, 1)}, OF_ANOTHER_KIND),
        ({"controller": CONTROLLERS["nc"]}, OF_ANOTHER_KIND),
        ({"slots": 2}, r"radio\.slots=2"),
    ],
)
def test_a_snapshot_of_another_kind_is_refused(bits, other, message):
    loop, kept = crowd(), crowd(**other).snapshot()
    before = bits(loop)
    with pytest.raises(ConfigError, match=message):
        loop.restore(kept)
    assert bits(loop) == before


def into_the_middle(world):
    """Wheels that drive every robot at full speed into one clump [m/s]."""
    x, y, theta = world.state.pose.T
    off = np.angle(np.exp(1j * (np.arctan2(-y, -x) - theta)))
    speed = world.scenario.robot.max_speed
    return speed * np.clip(np.stack([1.0 - off, 1.0 + off], axis=1), -1.0, 1.0)


@pytest.mark.parametrize(("n_robots", "before"), [(1, 40), (2, 7), (15, 0), (15, 1), (15, 30),
                                                  (15, 97), (15, 201), (15, 460)])  # fmt: skip
def test_robots_in_a_clump_go_on_bit_for_bit(go, n_robots, before):
    scenario = find_scenario("es1", {**conftest.CROWD, "n_robots": n_robots})
    used, copied = (ForagingWorld([scenario], [before], "rigid") for _ in range(2))
    noise = 0.04 * np.random.default_rng(1).normal(size=(before + 250, n_robots, 2))
    for tick, push in enumerate(noise):
        if tick == before:
            copied._physics.restore(copied._physics.snapshot(), copied.scenarios)
        go(used, into_the_middle(used) + push)
        go(copied, into_the_middle(copied) + push)
        assert_array_equal(used.state.pose, copied.state.pose)


def test_a_pymunk_that_keeps_its_contacts_otherwise_is_refused(monkeypatch):
    loop = crowd()
    run(2, loop)
    monkeypatch.setattr(pymunk.Space, "collision_slop", 0.5)  # not what is found in memory
    with pytest.raises(ConfigError, match="stores its contacts in an unknown layout"):
        loop.snapshot()


def test_the_threads_that_go_on_are_awaited_when_one_fails():
    loop, done = crowd(physics="kinematic", threads=3), []

    def work(first, last):
        if first == 0:
            raise RuntimeError("mine")
        time.sleep(0.05)
        done.append(first)

    with pytest.raises(RuntimeError, match="mine"):
        loop._on_all_threads(work)
    assert sorted(done) == [1, 2]
