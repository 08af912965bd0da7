"""The grid in numba's simulator of a GPU, functions as plain Python: the same bits as on a CPU."""

import pytest

from tests.scripts import run_python

pytestmark = pytest.mark.cuda

START = """
import sys
import numpy as np
import baselines.controllers
import training.controllers
import swarm_forage_env.foraging.task
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.columns import check_same_bits
"""

WORLDS = (
    START
    + """
scenario, controller, n_worlds, ticks, *numbers = sys.argv[1:]
scenario = find_scenario(scenario, dict(pair.split("=") for pair in numbers))
loops = [
    Loop(scenario, CONTROLLERS[controller], range(int(n_worlds)), "kinematic") for _ in range(2)
]
for loop in loops:  # everybody knows something, and tells it from the first tick on
    rng, beliefs = np.random.default_rng(3), loop.controller.minds["estimator"]["belief"]
    beliefs["known"] = beliefs["visited"] = rng.integers(0, 2, beliefs["known"].shape)
    beliefs["location"] = rng.uniform(-1.0, 1.0, beliefs["location"].shape)
    beliefs["p"] = rng.uniform(0.0, 3.0, beliefs["p"].shape)
cpu, gpu = loops[0], DeviceLoop(loops[1])
trips = np.zeros(cpu.world.robots.shape)
happened = np.zeros(3, int)
for tick in range(int(ticks)):
    cpu.step()
    gpu.step()
    trips += cpu.world.robots["reward"]
    exchange = cpu.controller.minds["estimator"]["exchange"]
    happened += cpu.world.robots["heard"]["n"].any(), exchange["is_valid"].any(), trips.any()
there = gpu.download()
gpu.check()
check_same_bits(cpu.world.robots, there.world.robots)
check_same_bits(cpu.world.worlds, there.world.worlds)
check_same_bits(cpu.controller.minds, there.controller.minds)
np.testing.assert_array_equal(trips, gpu.arrays["rewards"].copy_to_host())
print(*happened)
"""
)

STEPS = """
import sys
import numpy as np
import baselines.controllers
import tests.tasks.coverage_of_floor
from swarm_forage_env import array_env
from swarm_forage_env.foraging.areas import Area
from swarm_forage_env.foraging.scenario import Scenario, Task
from tests.columns import check_same_bits

MOVING = Scenario(  # a prey area that moves in the third tick
    task=Task(
        n_robots=3,
        areas=(
            Area(kind="nest", centre=(-0.4, 0.0)),
            Area(centre=(0.4, 0.0), moves_at=0.3, moves_to=(0.4, 0.3)),
        ),
    )
)

def on_cpu(array):
    return array.copy_to_host() if hasattr(array, "copy_to_host") else array

def same(mine, his):
    for one, other in zip(mine[:-1], map(on_cpu, his[:-1]), strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    assert mine[-1].keys() == his[-1].keys()
    for name in mine[-1]:
        np.testing.assert_array_equal(mine[-1][name], on_cpu(his[-1][name]))

options = {"n_worlds": 3, "max_cycles": 3, "decision_period": 2} | eval(sys.argv[1])
scenario = options.pop("scenario", "es1")
if scenario == "es1":
    options = {"task.n_robots": 1 + options.get("learners", 2)} | options
cpu, gpu = (
    array_env(scenario, device=device, physics="kinematic", **options)
    for device in ("cpu", "cuda")
)
rng, space = np.random.default_rng(1), cpu.action_space
is_discrete = hasattr(space, "n")

def drawn(*shape):
    if is_discrete:
        return rng.integers(space.n, size=shape)
    return rng.uniform(space.low, space.high, (*shape, *space.shape)).astype(np.float32)

same(cpu.reset(seed=5), gpu.reset(seed=5))
outputs = None
for step in range(7):
    actions = drawn(cpu.n_worlds, len(cpu.learners))
    if step % 3 == 2:  # worlds that end begin anew in the same launch
        mine = cpu.step_and_reset(actions)
        his = gpu.step_and_reset(gpu.memory.to_device(actions), outputs)
        same((*mine[:4], {}), (*his[:4], {}))
        assert outputs is None or his.outputs is outputs
        outputs = his.outputs
        continue
    same(cpu.step(actions), gpu.step(gpu.memory.to_device(actions)))
    over = cpu.is_over
    assert (gpu.is_over == over).all()
    if over.any():
        same(cpu.reset(worlds=over), gpu.reset(worlds=over))
there = gpu.download()
np.testing.assert_array_equal(cpu.log(), on_cpu(gpu.log()))
for mine, his in (
    (cpu.world.robots, there.world.robots),
    (cpu.world.worlds, there.world.worlds),
    (cpu.loop.controller.minds, there.loop.controller.minds),
):
    check_same_bits(mine, his)
if gpu.is_over.any():
    gpu.reset(worlds=gpu.is_over)
kept, before = gpu.snapshot(), gpu.world.robots[1].copy()
actions[1] = space.n if is_discrete else np.nan
gpu.step(gpu.memory.to_device(actions))
try:
    gpu.check()
except ValueError as error:
    print(error)
check_same_bits(before, gpu.world.robots[1])  # the world has stood still
gpu.restore(kept)
gpu.reset(worlds=[1], seed=9), cpu.reset(worlds=[1], seed=9)
np.testing.assert_array_equal(cpu.state(), gpu.state())
kept, after = gpu.snapshot(), []
for _ in range(2):  # what was done is undone, and done again
    gpu.restore(kept)
    gpu.reset(seed=6)
    seen = gpu.step(gpu.memory.to_device(drawn(gpu.n_worlds, len(gpu.learners)) * 0))[0]
    after.append(on_cpu(seen))
np.testing.assert_array_equal(*after)
"""


EXCHANGES = (
    STEPS.partition("options = {")[0]
    + """
options = {
    "n_worlds": 3, "learn": "weighting", "step_on": "exchange", "max_cycles": 36, "learners": 2,
    "stagger": True, "shaping": 0.5, "task.n_robots": 3, "task.start_radius": 0.25,
    "radio.max_range": float(sys.argv[1]), "observation": ["layer", "time_left"],
}
cpu, gpu = (
    array_env("es1", device=device, physics="kinematic", **options) for device in ("cpu", "cuda")
)
same(cpu.reset(seed=5), gpu.reset(seed=5))
for env in (cpu, gpu.download()):  # everybody knows something, and tells it from the first tick on
    rng, beliefs = np.random.default_rng(3), env.loop.controller.minds["estimator"]["belief"]
    beliefs["known"] = beliefs["visited"] = True
    beliefs["location"] = rng.uniform(-1.0, 1.0, beliefs["location"].shape)
    beliefs["p"] = rng.uniform(0.0, 3.0, beliefs["p"].shape)
gpu._worlds.upload(range(3))
acts, steps = 0, []
for step in range(2):
    actions = np.random.default_rng(step).uniform(-1.0, 1.0, (3, 2, 2)).astype(np.float32)
    mine, his = cpu.step(actions), gpu.step(gpu.memory.to_device(actions))
    same(mine, his)
    acts += mine[-1]["acts"].sum()
    steps.append(cpu.episodes.steps.tolist())
    assert gpu.episodes.steps.tolist() == steps[-1]
    over = cpu.is_over
    if over.any():
        same(cpu.reset(worlds=over), gpu.reset(worlds=over))
there = gpu.download()
check_same_bits(cpu.world.robots, there.world.robots)
check_same_bits(cpu.world.worlds, there.world.worlds)
check_same_bits(cpu.loop.controller.minds, there.loop.controller.minds)
print(int(acts), steps)
"""
)


ADDED = ["time_left", "robot_id", "one_hot", "previous_action"]


BLANK = (
    START
    + """
scenario, controller = find_scenario("es1", {"task.n_robots": "3"}), CONTROLLERS["ssgikf"]
many = DeviceLoop(Loop(scenario, controller, range(7), "kinematic", is_blank=True))
assert not many.download().world.robots["pose"].any()
many.reset(range(4, 11))
alone = Loop(scenario, controller, [10], "kinematic")
for _ in range(5):
    many.step()
    alone.step()
many.check()
there = many.download()
check_same_bits(there.world.robots[-1], alone.world.robots[0])
check_same_bits(there.controller.minds[-1], alone.controller.minds[0])
poses = there.world.robots["pose"]
print(len(np.unique(poses[:, 0], axis=0)), poses.shape, there.world.robots["wheels"].any())
"""
)


BENCH = """
import baselines.controllers
from baselines.evaluation.bench import gpu
from baselines.evaluation.bench.cases import Case
from swarm_forage_env.scenarios import find_scenario

gpu.TICKS = gpu.DECISIONS = 1
scenario = find_scenario("es1", {"task.n_robots": "2"})
found = gpu.measure_case(Case("es1 x 1", scenario, 1, warm_up=5), 1, quick=True)
assert found["gpu"] > 0.0 and found["cpu"] > 0.0 and found["environment"] > 0.0
assert found["first_step_s"] > 0.0 and found["made_s"] > 0.0
print(found["shares"], found["bandwidth"], found["share_of_card"], found["joules_per_million"])
print(found["bytes_per_robot_step"])
"""


def run(script, *arguments):
    """What a script prints that runs in the simulator."""
    simulated = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1", "PYTHONWARNINGS": ""}
    return run_python("-c", script, *arguments, **simulated)


@pytest.mark.parametrize("controller", ["ssgikf", "covariance", "learned-sceptical"])
def test_worlds_on_the_grid_are_the_worlds_of_a_cpu(controller):
    heard, exchanged, _ = map(int, run(WORLDS, "es1", controller, 2, 25).split())
    assert heard
    assert exchanged


@pytest.mark.parametrize(
    "options",
    [
        {"learn": "motion", "learners": 4, "reward": "team", "stagger": True},
        {"learn": "weighting", "normalise": False},
        {"learn": "both", "action": "course", "randomise": {"radio.max_range": (0.1, 0.2)}},
        {"learn": "motion", "shaping": 0.5, "stack": 3, "observation": ["layer", *ADDED]},
        {"learn": "motion", "shaping": 0.5, "reward": "team", "discrete": True, "learners": 3},
        {"learn": "motion", "scenario": "MOVING", "shaping": 1.0, "stagger": True},
        {"learn": "motion", "scenario": "aggregation", "task.n_robots": 4, "stagger": True},
        {"learn": "motion", "scenario": "coverage", "reward": "team", "discrete": True},
        {"learn": "weighting", "faults.liar.share": 0.4, "task.n_robots": 4},
        {"learn": "both", "discrete": (3, 4), "observation": ADDED, "normalise": False},
        {"learn": "everything", "stagger": True, "shaping": 0.5, "radio.max_range": 0.5},
        {"learn": "everything", "discrete": True, "stack": 2, "observation": ["layer", *ADDED]},
    ],
    ids=lambda options: "-".join([options["learn"], *list(options)[1:]]),
)
def test_an_environment_on_the_grid_is_that_of_a_cpu(options):
    told = run(STEPS, repr(options).replace("'MOVING'", "MOVING"))
    assert told.startswith("actions of world 1: must be finite and within the action space")


@pytest.mark.parametrize(
    ("reach", "told"),
    [
        (0.25, "2 [[5, 24, 36], [12, 36, 36]]"),  # one world exchanges, two run to their ends
        (0.3, "5 [[5, 5, 5], [12, 24, 36]]"),  # all have exchanged when the CPU asks
    ],
)
def test_worlds_that_have_exchanged_stand_still_until_all_others_have(reach, told):
    assert run(EXCHANGES, reach) == told


def test_worlds_that_no_cpu_has_made_are_those_of_their_seeds():
    assert run(BLANK) == "7 (7, 3, 3) True"


def test_worlds_with_obstacles_and_faults_are_those_of_a_cpu():
    assert run(WORLDS, "mg1-hexagon", "ssgikf", 2, 10, "faults.liar.share=0.4")


def test_the_bench_tells_what_a_simulator_knows_and_leaves_the_rest_open():
    """Times of the GPU's own clock, the card and its energy are not known; bytes are."""
    unknown, n_bytes = run(BENCH).splitlines()
    assert unknown == "{} None None None"
    robots, minds, near = 520, 1, 4
    assert float(n_bytes) > 6 * robots + 4 * minds + 2 * near
