"""Every function of a robot, and the kernels of the grid, compile for a GPU; none is needed."""

import importlib
import pkgutil

import numpy as np
import pytest

import baselines.estimators
import baselines.motion
import baselines.oracles.controllers
import baselines.weighting
import swarm_forage_env.epuck
import swarm_forage_env.equations
import swarm_forage_env.foraging
from swarm_forage_env.compiler import bind_grid, bind_row
from swarm_forage_env.device_loop import grid_of
from swarm_forage_env.envs import decision_kernels as kernels
from swarm_forage_env.envs.extra_observations import (
    write_one_hot,
    write_previous_action,
    write_robot_id,
    write_time_left,
)
from swarm_forage_env.envs.whole_decision import decide_at_once
from swarm_forage_env.equations.differential_drive import drive_to_wheels
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.policies import LEARNABLE
from swarm_forage_env.foraging.rewards import potential
from swarm_forage_env.foraging.task import FORAGING
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import words_of
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.ticks import begin_worlds, run_ticks
from tests.cuda.conftest import COMPILED, ON_GRID

pytestmark = pytest.mark.cuda

TROUBLE = np.zeros(3, np.int64)

PACKAGES = (
    swarm_forage_env.epuck,
    swarm_forage_env.equations,
    swarm_forage_env.foraging,
    baselines.estimators,
    baselines.motion,
    baselines.weighting,
)

ON_CPU = {
    "find_neighbours note_neighbour compare_all_pairs": "the list of neighbours of a CPU",
    "largest_count cell_of cells_of": "the list of neighbours of a CPU",
    "acos": "matrices of positions in estimators that a GPU has not",
    "seed_streams": "a reset of the layers of a CPU",
    "start_stream _hashed _mixed": "seeds of episodes that a user gives",
    "write_events area_under is_touching is_near_obstacle": "events for rewards in NumPy",
    "repeat falsify": "in the place of what an estimator has not",
    "write_log": "the loop over worlds of the log",
    "add_errors": "the meter of an evaluation",
    "draw_robots draw_column doing_of believed_place": "what is drawn of a world",
    "no_gain": "the weighting of robots that have none",
    "reflex": "the default of a motion that has none",
}
"""Functions of foraging that no kernel of the grid calls, and why."""

NOT_OF_E_PUCKS = (
    "boids_inputs", "covariance_intersection", "cross_covariance", "dead_reckoning",
    "decentralised_ekf", "joint_update", "localisation", "pose_prediction", "small_matrices",
    "boids", "boids_foraging", "flock", "steering",
)  # fmt: skip
"""Files of estimators and motions that keep something of each pair of robots, or visit waypoints:
`device="cuda"` refuses them."""

OF_STEPS = (
    "drive_to_wheels drive_v1_to_wheels wheels_of course_to_command share_of_command"
    " log_beliefs log_counts write_robot_log write_counts localisation_error"
    " distance_to_kind potential farthest log_messages"
    " draw_seed _advance _sum _product _joined"
)
"""Functions of an environment's step, which have a test of their own."""


def loop_of(controller, n_worlds=2):
    """A block of worlds of es1, or of the task that the controller is for."""
    seeds = list(range(n_worlds))
    found = REFERENCES if controller in REFERENCES else CONTROLLERS
    chosen = FORAGING.raw_control if controller == "policy" else found[controller]
    scenario = "aggregation" if controller == "gather" else "es1"
    return Loop(find_scenario(scenario), chosen, seeds, "kinematic")


def kernels_of(controller):
    """The kernels of worlds and a controller, and what each is handed."""
    loop = loop_of(controller)
    world, layers, task = loop.world, loop.controller.compiled, loop.task.gpu
    functions = {**world.functions, **layers.functions, **task.functions}
    arrays = world.arrays, tuple(map(np.ascontiguousarray, layers.arrays))
    n_worlds, n_robots = world.robots.shape
    places = np.zeros((n_worlds, n_robots), np.uint64), np.zeros((n_worlds, n_robots, 3))
    starts = world.robots[0], *layers.firsts, np.zeros(n_worlds, np.uint64), *places
    modes, trouble = world.modes, world.trouble
    begin = bind_grid(begin_worlds, functions)
    return {
        "run": (bind_grid(run_ticks, functions), (*arrays, modes, trouble, 0, n_worlds, 10)),
        "begin": (begin, (*arrays, starts, 64, modes, trouble)),
    }


def called_by(function, found):
    """All functions that a kernel calls, by their qualified names."""
    plain = getattr(function, "py_func", function)
    if plain not in found:
        found.add(plain)
        for name in plain.__code__.co_names:
            value = plain.__globals__.get(name)
            if hasattr(value, "py_func"):
                called_by(value, found)
    return found


@pytest.mark.parametrize("controller", [*COMPILED, "policy"])
def test_ticks_compile_for_a_gpu(ptx, controller):
    kernel, arguments = kernels_of(controller)["run"]
    text = ptx(kernel, *arguments)
    assert ".target sm_90" in text
    assert text.count("bar.sync") == (13 if controller != "policy" else 11)
    assert "fma.rn" not in text  # each product is rounded by itself, as on a CPU


def test_ticks_of_another_task_of_e_pucks_compile_for_a_gpu(ptx):
    kernel, arguments = kernels_of("gather")["run"]
    assert ".target sm_90" in ptx(kernel, *arguments)


@pytest.mark.parametrize("controller", ["ssgikf", "covariance", "policy", "gather"])
def test_a_reset_compiles_for_a_gpu(ptx, controller):
    kernel, arguments = kernels_of(controller)["begin"]
    assert ".entry" in ptx(kernel, *arguments)


@pytest.mark.parametrize("learn", ["weighting", "motion", "both", "everything"])
def test_the_step_of_an_environment_compiles_for_a_gpu(ptx, learn):
    policy = LEARNABLE[learn]
    loop = loop_of("policy" if learn == "everything" else "nc")
    robots, worlds = loop.world.robots, loop.world.worlds
    minds = np.ascontiguousarray(loop.controller.compiled.arrays[0])
    learners, choices = np.arange(10), np.zeros((2, 10), np.int64)
    actions = np.zeros((2, 10, len(policy.action)), np.float32)
    seen, row, pair = np.zeros((2, 10, 60), np.float32), np.zeros(60, np.float32), np.zeros((2, 10))
    modes, both, form = np.zeros(2, np.int8), (0, 2), (actions[0], 0, 0, 0.3)
    fields = words_of(robots), words_of(minds), words_of(robots), np.zeros((3, 4), np.uint64), 10
    potentials, frames = np.stack([pair, pair]), np.zeros((2, 10, 2, 60), np.float32)
    numbers = {"write_raw": kernels.raw_of_numbers, "command": drive_to_wheels}
    add = kernels.add_nothing
    for write in (write_time_left, write_robot_id, write_one_hot, write_previous_action):
        add = bind_row(kernels.add_feature, {"features_before": add, "write_feature": write})
    beside = np.zeros((4, 2), np.int64), pair[:, 0].copy(), actions
    scaling = 0, 40, True, row, row > 0
    steps = [
        (
            kernels.check,
            {"check_actions": kernels.check_numbers},
            (actions, (row, row), TROUBLE, both),
        ),
        (kernels.check, {"check_actions": kernels.check_choices}, (choices, 5, TROUBLE, both)),
        (kernels.take, numbers, (fields, learners, actions, form, actions, pair, both)),
        (
            kernels.take,
            {"write_raw": kernels.raw_of_choice},
            (fields, learners, choices, form, actions, pair, both),
        ),
        (kernels.write_potentials, {"potential": potential}, (robots, worlds, pair, both)),
        (kernels.credit, {}, (learners, pair, potentials, (0.9, 0.5, True), potentials, both)),
        (
            kernels.observe,
            {"add_features": add},
            (fields, learners, scaling, beside, modes, (seen, frames, seen), both),
        ),
    ]
    if learn != "everything":  # there are exchanges
        ends = learners[:2]
        stop = worlds, minds, learners, ends, modes, ends, both
        steps.append((kernels.stop_at_exchanges, {}, stop))
        steps.append((kernels.write_acts, {}, (minds, learners, pair, both)))
    for template, functions, arguments in steps:
        assert ".entry" in ptx(bind_grid(template, functions), *arguments)


@pytest.mark.parametrize("learn", ["motion", "everything"])
def test_a_decision_in_one_launch_compiles_for_a_gpu(ptx, learn):
    loop = loop_of("policy" if learn == "everything" else "ssgikf")
    world, layers, task = loop.world, loop.controller.compiled, loop.task.gpu
    arrays = world.arrays, tuple(map(np.ascontiguousarray, layers.arrays))
    robots, minds = world.robots, arrays[1][0]
    n_worlds, n_robots = robots.shape
    learners, rewards = np.arange(n_robots), np.zeros((2, n_worlds, n_robots))
    actions = np.zeros((n_worlds, n_robots, len(LEARNABLE[learn].action)), np.float32)
    row, frames = np.zeros(60, np.float32), np.zeros((n_worlds, n_robots, 2, 60), np.float32)
    seen, stacked = (np.zeros((2, n_worlds, n_robots, n), np.float32) for n in (60, 120))
    fields = words_of(robots), words_of(minds), words_of(robots), np.zeros((3, 4), np.uint64), 10
    words, times = np.zeros((n_worlds, 4), np.uint64), np.arange(n_worlds)
    places = np.zeros(robots.shape, np.uint64), np.zeros((*robots.shape, 3))
    starts = world.robots[0], *layers.firsts, words[:, 0].copy(), *places
    functions = {
        **world.functions, **layers.functions, **task.functions,
        "write_raw": kernels.raw_of_numbers, "command": drive_to_wheels,
        "check_actions": kernels.check_numbers, "potential": potential,
        "add_features": kernels.add_nothing,
    }  # fmt: skip
    arguments = (
        (*arrays, world.trouble),
        (fields, learners, actions, (actions[0], 0, 0, 0.3), actions, (row, row)),
        (rewards, (0.9, 0.5, True), rewards[0]),
        (fields, (0, 40, True, row, row > 0), np.zeros((4, 2), np.int64), frames),
        (times, times, words), starts, (10, 2, 360, 64),
        (rewards, seen, stacked, times > 0), (0, n_worlds),
    )  # fmt: skip
    text = ptx(bind_grid(decide_at_once, functions), *arguments)
    assert text.count(".entry") == 1
    assert "fma.rn" not in text


@pytest.mark.parametrize("controller", ["nc", "policy"])
def test_the_log_compiles_for_a_gpu(ptx, controller):
    loop = loop_of(controller)
    layers = loop.controller.compiled
    minds = np.ascontiguousarray(layers.arrays[0])
    arguments = (
        loop.world.robots,
        minds,
        loop.world.worlds,
        np.arange(10),
        np.zeros((2, 10, 6)),
        (0, 2),
    )
    log = FORAGING.gpu.log[layers.has_beliefs]
    assert ".entry" in ptx(bind_grid(kernels.write_log, {"log": log}), *arguments)


def test_the_compiled_controllers_call_all_that_any_does():
    found = {name: set() for name in ON_GRID}
    for name, own in found.items():
        for kernel, _ in kernels_of(name).values():
            called_by(kernel, own)
    names = {name: {each.__qualname__ for each in own} for name, own in found.items()}
    assert set().union(*names.values()) == set().union(*(names[name] for name in COMPILED))


def test_every_function_of_foraging_is_called_or_left_out_with_a_reason():
    found = set()
    for name in (*ON_GRID, "policy", "gather"):
        for kernel, _ in kernels_of(name).values():
            called_by(kernel, found)
    known = {(each.__module__, each.__name__) for each in found}
    left_out = set(" ".join([*ON_CPU, OF_STEPS]).split())
    missing = set()
    for package in PACKAGES:
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            module = importlib.import_module(info.name)
            for value in vars(module).values():
                is_own = getattr(value, "__module__", "") == info.name and hasattr(value, "py_func")
                if is_own and (info.name, value.__name__) not in known:
                    missing.add(f"{info.name.rpartition('.')[2]}.{value.__name__}")
    refused = {each for each in missing if each.partition(".")[0] in NOT_OF_E_PUCKS}
    assert {each.partition(".")[2] for each in missing - refused} <= left_out


def test_few_worlds_are_launched_in_silence_and_other_peoples_kernels_are_not():
    from numba import cuda

    on = grid_of(2, 10)  # warnings are errors
    assert kernels_of("nc")["run"][0][on].griddim == (1, 1, 1)
    with pytest.warns(Warning, match="under-utilization"):
        cuda.jit(lambda out: None)[on]


@pytest.mark.parametrize(
    ("controller", "reason"),
    [("boids-goal", "each pair"), ("oracle-weighting", "NumPy"), ("no-error", "template")],
)
def test_what_does_not_run_on_a_gpu_is_refused_by_name(controller, reason):
    with pytest.raises(ConfigError, match=f"'{controller}' runs on a CPU only.*{reason}"):
        loop_of(controller).controller.check_on_gpu()
