"""Every function of a robot, and the kernels of the grid, compile for a GPU; none is needed."""

from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest

import baselines.oracles.controllers  # noqa: F401 references, by name
from swarm_forage_env.compiler import bind_grid
from swarm_forage_env.envs import decision_kernels as kernels
from swarm_forage_env.envs.whole_decision import decide_at_once
from swarm_forage_env.equations.differential_drive import drive_to_wheels
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging import metrics
from swarm_forage_env.foraging.global_state import ForagingState
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
    world, layers = loop.world, loop.controller.compiled
    functions = {**world.functions, **layers.functions, **loop.task.gpu}
    arrays = world.arrays, tuple(map(np.ascontiguousarray, layers.arrays))
    n_worlds, n_robots = world.robots.shape
    places = np.zeros((n_worlds, n_robots), np.uint64), np.zeros((n_worlds, n_robots, 3))
    starts = world.robots[0], *layers.firsts, np.zeros(n_worlds, np.uint64), *places
    modes, errors = world.modes, world.errors
    begin = bind_grid(begin_worlds, functions)
    return {
        "run": (bind_grid(run_ticks, functions), (*arrays, modes, errors, 0, n_worlds, 10)),
        "begin": (begin, (*arrays, starts, 64, modes, errors)),
    }


def called_by(function, found):
    """All functions that a kernel calls."""
    plain = getattr(function, "py_func", function)
    if plain not in found:
        found.add(plain)
        for name in plain.__code__.co_names:
            value = plain.__globals__.get(name)
            if hasattr(value, "py_func"):
                called_by(value, found)
    return found


@pytest.mark.parametrize(
    ("controller", "n_barriers"),
    [*((each, 13) for each in COMPILED), ("policy", 11), ("gather", 11)],
)
def test_ticks_compile_for_a_gpu(ptx, controller, n_barriers):
    kernel, arguments = kernels_of(controller)["run"]
    text = ptx(kernel, *arguments)
    assert ".target sm_90" in text
    assert text.count("bar.sync") == n_barriers
    assert "fma.rn" not in text  # each product is rounded by itself, as on a CPU


@pytest.mark.parametrize("controller", ["ssgikf", "covariance", "policy", "gather"])
def test_a_reset_compiles_for_a_gpu(ptx, controller):
    kernel, arguments = kernels_of(controller)["begin"]
    assert ".entry" in ptx(kernel, *arguments)


def decision(learn):
    """A loop in which a layer is learned, and what a decision of its learners is handed."""
    loop = loop_of("policy" if learn == "everything" else "ssgikf")
    robots, minds = loop.world.robots, np.ascontiguousarray(loop.controller.compiled.arrays[0])
    actions = np.zeros((2, 10, len(LEARNABLE[learn].action)), np.float32)
    row = np.zeros(60, np.float32)
    return SimpleNamespace(
        loop=loop, robots=robots, minds=minds, actions=actions, learners=np.arange(10), row=row,
        fields=(words_of(robots), words_of(minds), words_of(robots), np.zeros((3, 4), "u8"), 10),
        form=(actions[0], 0, 0, 0.3), scaling=(0, 40, True, row, row > 0),
        frames=np.zeros((2, 10, 2, 60), np.float32), additions=np.zeros((4, 2), np.int64),
        terms=(0.9, 0.5, True),
    )  # fmt: skip


@pytest.mark.parametrize("learn", ["weighting", "motion", "both", "everything"])
def test_the_step_of_an_environment_compiles_for_a_gpu(ptx, learn):
    it, both = decision(learn), (0, 2)
    seen, pair = np.zeros((2, 10, 60), np.float32), np.zeros((2, 10))
    modes, choices = np.zeros(2, np.int8), np.zeros((2, 10), np.int64)
    worlds, rewards = it.loop.world.worlds, np.stack([pair, pair])

    def compiles(template, functions, *arguments):
        assert ".entry" in ptx(bind_grid(template, functions), *arguments, both)

    state, crediting = (it.robots, worlds, TROUBLE), (pair.copy(), it.terms, pair)
    numbers = {"write_raw": kernels.raw_of_continuous, "command": drive_to_wheels}
    for given, limits, check, functions in (
        (it.actions, (it.row, it.row), kernels.check_numbers, numbers),
        (choices, 5, kernels.check_choices, {"write_raw": kernels.raw_of_discrete}),
    ):
        names = {**functions, "check_actions": check, "potential": potential}
        acting = it.fields, it.learners, given, it.form, it.actions, limits
        compiles(kernels.act, names, state, acting, crediting)
    compiles(kernels.settle, {"potential": potential}, state, crediting, it.learners, rewards)
    extras = it.additions, pair[:, 0].copy(), it.actions
    observed = it.scaling, extras, modes, (seen, it.frames, seen)
    compiles(kernels.observe, {}, it.fields, it.learners, *observed)
    if learn != "everything":  # there are exchanges
        ends = it.learners[:2]
        stop = worlds, it.minds, it.learners, ends, modes, ends
        compiles(kernels.stop_at_exchanges, {}, *stop)
        compiles(kernels.write_acts, {}, it.minds, it.learners, pair)


@pytest.mark.parametrize("learn", ["motion", "everything"])
def test_a_decision_in_one_launch_compiles_for_a_gpu(ptx, learn):
    it = decision(learn)
    world, layers = it.loop.world, it.loop.controller.compiled
    arrays = world.arrays, (it.minds, *map(np.ascontiguousarray, layers.arrays[1:]))
    rewards, times = np.zeros((2, 2, 10)), np.arange(2)
    seen, stacked = (np.zeros((2, 2, 10, n), np.float32) for n in (60, 120))
    words, places = np.zeros((2, 4), "u8"), (np.zeros((2, 10), "u8"), np.zeros((2, 10, 3)))
    starts = it.robots[0], *layers.firsts, words[:, 0].copy(), *places
    functions = {
        **world.functions, **layers.functions, **it.loop.task.gpu,
        "write_raw": kernels.raw_of_continuous, "command": drive_to_wheels,
        "check_actions": kernels.check_numbers, "potential": potential,
    }  # fmt: skip
    arguments = (
        (*arrays, world.errors),
        (it.fields, it.learners, it.actions, it.form, it.actions, (it.row, it.row)),
        (rewards[1], it.terms, rewards[0]),
        (it.fields, it.scaling, it.additions, it.frames),
        (times, times, words), starts, (10, 2, 360, 64),
        (rewards, seen, stacked, times > 0), (0, 2),
    )  # fmt: skip
    text = ptx(bind_grid(decide_at_once, functions), *arguments)
    assert text.count(".entry") == 1
    assert "fma.rn" not in text


@pytest.mark.parametrize("controller", ["ssgikf", "covariance", "learned-sceptical"])
def test_what_measures_an_episode_compiles_for_a_gpu(ptx, controller):
    it, sums = loop_of(controller), (np.zeros(2), np.zeros(2, np.int64))
    robots, minds = it.world.robots, np.ascontiguousarray(it.estimators)
    meant, counts = robots["round_trips"] == 0, np.zeros((2, 100), np.int32)
    for template, *arguments in (
        (metrics.add_errors, robots, minds, it.world.worlds, meant, *sums),
        (metrics.count_on_path, robots, 7, counts),
    ):
        text = ptx(bind_grid(template, {}), *arguments, (0, 2))
        assert ".entry" in text
        assert "fma.rn" not in text


@pytest.mark.parametrize("controller", ["nc", "policy"])
def test_the_log_compiles_for_a_gpu(ptx, controller):
    loop = loop_of(controller)
    layers = loop.controller.compiled
    minds = np.ascontiguousarray(layers.arrays[0])
    place = loop.world.robots, minds, loop.world.worlds, np.arange(10), np.zeros((2, 10, 6))
    log = ForagingState.logs[layers.has_beliefs]
    assert ".entry" in ptx(bind_grid(kernels.write_log, {"log": log}), *place, (0, 2))


def test_the_compiled_controllers_call_all_that_any_does():
    found = {name: set() for name in ON_GRID}
    for name, own in found.items():
        for kernel, _ in kernels_of(name).values():
            called_by(kernel.dispatcher, own)
    names = {name: {each.__qualname__ for each in own} for name, own in found.items()}
    assert set().union(*names.values()) == set().union(*(names[name] for name in COMPILED))


def test_every_controller_runs_on_a_gpu_or_is_refused():
    runs = set()
    for name in CONTROLLERS:
        with suppress(ConfigError):
            loop_of(name, 1).controller.check_on_gpu()
            runs.add(name)
    assert runs == {*ON_GRID, "gather"}


@pytest.mark.parametrize(
    ("controller", "reason"),
    [("boids-goal", "each pair"), ("oracle-weighting", "NumPy"), ("no-error", "template")],
)
def test_what_does_not_run_on_a_gpu_is_refused_by_name(controller, reason):
    with pytest.raises(ConfigError, match=f"'{controller}' runs on a CPU only.*{reason}"):
        loop_of(controller).controller.check_on_gpu()
