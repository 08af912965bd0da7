"""Episodes on the grid, in numba's simulator of a GPU: those of a CPU, found again as theirs."""

import pytest

from tests.cuda.test_simulator import run

pytestmark = pytest.mark.cuda

START = """
import sys
from dataclasses import replace
from pathlib import Path
import training.controllers
from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.runner import evaluate
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario

NEAR = {  # within seconds, robots have found areas, exchanged and brought something home
    "task.areas": (
        {"kind": "nest", "centre": (-0.19, 0.0)}, {"centre": (0.19, 0.0)},
        {"kind": "nest", "centre": (0.0, -0.19)}, {"centre": (0.0, 0.19)},
    ),
    "task.n_robots": 3, "task.start_radius": 0.08, "robot.cruise_speed": 0.12,
}
"""

EPISODES = (
    START
    + """
scenario, controller, numbers = find_scenario(sys.argv[1]), sys.argv[2], eval(sys.argv[3])
near = NEAR if scenario.name == "es1" else {}
scenario = find_scenario(scenario, {**near, **numbers})
what = scenario, find_controller(controller), (5, 8), "kinematic"
cpu, gpu = (
    [replace(each, wall_s=0.0) for each in run_episodes(*what, device=device)]
    for device in ("cpu", "cuda")
)
assert cpu == gpu
for each in gpu:
    print({name: value for name, value in vars(each).items() if value})
"""
)

PLANS = (
    START
    + """
import baselines.evaluation.runner as runner

folder, numbers = Path(sys.argv[1]), ["task.n_robots=2", "task.duration=0.3"]
options = EvaluateOptions("es1", ["nc", "ssgikf"], 3, settings=numbers, physics="kinematic")
plans = [options.plan(folder / name, device="cuda") for name in ("gpu", "cpu")]
gpu, cpu = JoblibBackend(device="cuda"), JoblibBackend()
one = replace(options, controllers=["nc"]).plan(folder / "one", device="cuda")
print([len(seeds) for plan in (plans[0], one) for _, seeds in plan.blocks(gpu)])
print(list(plans[0].run(gpu)), list(plans[1].run(cpu)))
found = [[replace(each, wall_s=0.0) for each in plan.results()] for plan in plans]
assert found[0] == found[1]
print(replace(options, episodes=4).plan(folder / "gpu").n_todo)
runner.ROWS_ON_GPU = 4
print([len(seeds) for _, seeds in replace(options, episodes=8).plan(folder / "gpu").blocks(gpu)])
"""
)

REFUSALS = (
    START
    + """
folder = Path(sys.argv[1])

def refused(scenario, controller, physics):
    try:
        EvaluateOptions(scenario, [controller], physics=physics).plan(folder / "x", device="cuda")
    except ValueError as error:
        print(error)

refused("es1", "boids-adaptive", "kinematic")
refused("waypoints-10", "boids-goal", None)
try:
    run_episodes(find_scenario("es1"), find_controller("nc"), [0], observer=print, device="cuda")
except ValueError as error:
    print(error)
try:
    run_episodes(find_scenario("es1"), find_controller("nc"), [0], device="gpu")
except ValueError as error:
    print(error)
assert not list(folder.iterdir())
"""
)


@pytest.mark.parametrize(
    ("scenario", "controller", "numbers", "told"),
    [
        ("es1", "ssgikf", {"task.duration": 7.3}, "round_trips messages localisation_error_m"),
        ("es1", "learned-both", {"task.duration": 4.1}, "on_path_share recruited_at_s"),
        (
            "es1", "ssgikf", {"task.duration": 10.3, "faults.liar.share": 0.4},
            "round_trips_sound on_path_share_sound localisation_error_sound_m",
        ),
        ("aggregation", "gather", {"task.duration": 1.0, "task.n_robots": 3}, "scenario"),
    ],
)  # fmt: skip
def test_an_episode_on_the_grid_is_that_of_a_cpu(scenario, controller, numbers, told):
    episodes = run(EPISODES, scenario, controller, numbers)
    assert all(f"'{name}'" in episodes for name in told.split())


def test_what_was_evaluated_on_the_grid_is_found_on_a_cpu_and_runs_in_large_blocks(tmp_path):
    blocks, done, missing, small = run(PLANS, tmp_path).splitlines()
    assert blocks == "[3, 3, 3]"
    assert done == "[3, 3] [3, 3]"
    assert missing == "2"
    assert small == "[2, 2, 1, 2, 2, 1]"


def test_what_runs_on_a_cpu_only_is_refused_before_anything_is_written(tmp_path):
    controller, task, observer, device = run(REFUSALS, tmp_path).splitlines()
    assert controller.startswith("--device='cuda': controller 'boids-adaptive' runs on a CPU only")
    assert task == "--device='cuda': the task waypoints runs on a CPU only; use device='cpu'"
    assert observer == "device='cuda': an observer looks at every tick, on a CPU only"
    assert device == "device='gpu': must be 'cpu' or 'cuda'"
