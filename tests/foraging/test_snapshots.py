"""A snapshot, a copy and a pickle of a running block go on from the same tick, bit for bit."""

import copy
import hashlib
import pickle
import subprocess
import sys
import time

import pytest
from numpy.testing import assert_array_equal

from baselines.controller import LayeredController
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.physics import contact_memory
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import TASKS
from tests.outside import OutsideMotionPart

ENGINES = ("rigid", "kinematic")
CROWD = {"n_robots": 15, "arena.length": 0.8, "arena.width": 0.8, "area_distance": 0.59,
         "area_radius": 0.05, "cruise_speed": 0.12}  # fmt: skip
"""So narrow that bodies touch each other and the walls in every tick."""
CONTROLLER = CONTROLLERS["dsgiff"].with_parameters({"beta": 0.1})


def crowd(seeds=(3, 1, 2), physics="rigid", controller=CONTROLLER, threads=1):
    return Loop(find_scenario("es1", CROWD), controller, seeds, physics, threads)


def run(n_ticks, *loops):
    for _ in range(n_ticks):
        for loop in loops:
            loop.step()


def pickled(loop):
    return pickle.loads(pickle.dumps(loop))


COPIES = {"a copy": copy.deepcopy, "a pickle": pickled}
every_copy = pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)


@pytest.mark.parametrize("physics", ENGINES)
@pytest.mark.parametrize("threads", [1, 2])
@every_copy
def test_a_copy_goes_on_as_the_original_and_as_one_never_copied(bits, physics, threads, copied):
    original, twin = (crowd(physics=physics, threads=threads) for _ in range(2))
    run(150, original, twin)
    other = copied(original)
    assert bits(other) == bits(original)
    for _ in range(10):
        run(20, original, twin, other)
        assert bits(other) == bits(original) == bits(twin)
    assert original.world.robots["messages"].sum() > 0


@pytest.mark.parametrize("physics", ENGINES)
def test_a_snapshot_is_restored_any_number_of_times(bits, physics):
    loop, twin = (crowd(physics=physics) for _ in range(2))
    run(150, loop, twin)
    snapshot, minds, robots = loop.snapshot(), loop.controller.minds, loop.world.robots
    run(100, loop, twin)
    assert bits(loop) == bits(twin)
    for kept in (snapshot, pickle.loads(pickle.dumps(snapshot))):
        run(30, loop)
        loop.restore(kept)
        assert loop.controller.minds is minds
        assert loop.world.robots is robots
        run(100, loop)
        assert bits(loop) == bits(twin)


@pytest.mark.parametrize("physics", ENGINES)
def test_a_snapshot_is_restored_in_another_block(bits, physics):
    loop, other = crowd(physics=physics), crowd((7, 8, 9), physics)
    run(150, loop)
    run(20, other)
    other.restore(loop.snapshot())
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
    wide = find_scenario("es1", {"n_robots": 15, "max_range": 0.3, "tick": 0.2, "radius": 0.03})
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


CONTROLLED = {
    "a weighting in NumPy that knows the truth": REFERENCES["oracle-weighting"],
    "a filter that keeps something of each pair": find_controller(
        "decentralised_ekf+filter+subsumption"
    ),
}


@pytest.mark.parametrize("controller", CONTROLLED.values(), ids=CONTROLLED)
@every_copy
def test_every_kind_of_controller_is_copied(bits, controller, copied):
    original = crowd(controller=controller)
    run(150, original)
    other = copied(original)
    run(100, original, other)
    assert bits(other) == bits(original)


def in_numpy():
    """The subsumption motion, called on arrays, which remembers and draws in NumPy's memory."""
    motion = OutsideMotionPart(SubsumptionParameters())
    return LayeredController("numpy", CONTROLLER.estimator, CONTROLLER.weighting, motion)


def test_what_a_motion_in_numpy_remembers_is_kept(bits):
    loop, twin = (crowd(controller=in_numpy()) for _ in range(2))
    run(100, loop, twin)
    kept, other = loop.snapshot(), copy.deepcopy(loop)
    run(60, loop, twin, other)
    assert bits(other) == bits(loop) == bits(twin)
    for _ in range(2):
        loop.restore(kept)
        run(60, loop)
        assert bits(loop) == bits(twin)


def test_the_robots_of_a_learner_of_everything_are_copied():
    policy = TASKS["foraging"].raw_control
    loop = crowd(controller=policy)
    loop.controller.minds["speak"] = 1.0
    loop.world.robots["action"]["wheels"] = 0.7, 0.5
    run(100, loop)
    kept, other = loop.snapshot(), pickled(loop)
    run(50, loop, other)
    assert_array_equal(loop.world.robots, other.world.robots)
    assert loop.world.robots["messages"].sum() > 0
    loop.controller.minds["speak"] = -1.0
    loop.restore(kept)
    run(50, loop)
    assert_array_equal(loop.world.robots, other.world.robots)


GO_ON = """
import hashlib, pickle, sys
loop = pickle.load(sys.stdin.buffer)
for _ in range(50):
    loop.step()
print(hashlib.sha256(loop.world.robots["pose"].tobytes()).hexdigest())
"""


def test_a_pickle_goes_on_in_another_process():
    loop = crowd(controller=REFERENCES["oracle-weighting"])
    run(100, loop)
    there = subprocess.run(
        [sys.executable, "-c", GO_ON], input=pickle.dumps(loop), capture_output=True, check=True,
        timeout=300,
    )  # fmt: skip
    run(50, loop)
    here = hashlib.sha256(loop.world.robots["pose"].tobytes()).hexdigest()
    assert there.stdout.decode().strip() == here


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


OTHERS = {
    "other engine": {"physics": "kinematic"},
    "fewer worlds": {"seeds": (3, 1)},
    "other controller": {"controller": CONTROLLERS["nc"]},
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_a_snapshot_of_another_kind_is_refused(bits, other):
    loop, kept = crowd(), crowd(**other).snapshot()
    before = bits(loop)
    with pytest.raises(ConfigError, match=r"a snapshot of the task foraging.* cannot be restored"):
        loop.restore(kept)
    assert bits(loop) == before


def test_a_snapshot_with_other_slots_is_refused():
    loop = crowd()
    other = Loop(find_scenario("es1", {**CROWD, "slots": 2}), CONTROLLER, (3, 1, 2))
    with pytest.raises(ConfigError, match=r"radio\.slots=2"):
        loop.restore(other.snapshot())


def test_a_pymunk_that_keeps_its_contacts_otherwise_is_refused(monkeypatch):
    loop = crowd()
    monkeypatch.setattr(contact_memory.Space, "stamp", contact_memory.Space.last_step)
    run(2, loop)
    with pytest.raises(ConfigError, match="keeps its contacts in a way that is not known"):
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
