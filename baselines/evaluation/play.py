"""Contents of a playground page: controllers as WebAssembly, initial worlds, and sliders."""

import json
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numba.core import types

from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig, parse_settings
from baselines.evaluation.plot_style import colour_of
from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.compiler import bind
from swarm_forage_env.device_loop import LAYERS, WORLD
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.envs.decision_kernels import observe
from swarm_forage_env.envs.pilot import READ_ONLY_ARRAYS, Pilot, pilot_and_layers
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.equations.neighbours import EMPTY
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.drawing import COLUMNS, run_and_draw
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import spans_of
from swarm_forage_env.parameters import leaves, with_full_names
from swarm_forage_env.record import offset_of
from swarm_forage_env.rendering.playground import (
    ArrayPlace,
    Driving,
    Patch,
    Program,
    Slider,
    playground,
)
from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.replay import obstacles_shown
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.targets import linked_for_web, llvm_text_of, memory_of, ticks_of
from swarm_forage_env.task import stage_of
from swarm_forage_env.ticks import START, begin_worlds, nothing

MAX_CONTROLLERS = 2  # maximum number of swarms side by side
FRAME = 1.0  # time between two frames of a page [s]

ROBOTS, LIARS, OBSTACLES = "task.n_robots", "faults.liar.share", "obstacles"
WORDS = {  # settings that a visitor changes: label and unit
    ROBOTS: ("Robots", ""),
    "radio.max_range": ("Radio range", "m"),
    "radio.bearing_noise": ("Bearing noise", "rad"),
    "sensors.wheel_noise": ("Wheel noise", ""),
    LIARS: ("Liars", "%"),
    OBSTACLES: ("Obstacles", ""),
    "weighting.beta": ("Beta", ""),
}

CONTROLLER_PARAMETERS = ("weighting.beta",)

FACTORS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)
"""Values of a setting, as multiples of the usual one; those that are refused are left out."""

VALUES: Mapping[str, tuple[float, ...]] = {  # values of other settings; the usual one is added
    ROBOTS: (2, 3, 5, 10, 15, 20, 30, 40, 50),
    LIARS: (0.0, 0.1, 0.2, 0.3, 0.4, 0.5),
    OBSTACLES: (0, 1),
}

RECORDED = 300.0  # length of the recorded part of an episode [s]
GROWTH = 1.1  # factor by which a start circle is widened until the robots fit
WALL = {"length": 0.2, "radius": 0.01}  # of an obstacle between the start circle and an area [m]


@dataclass(frozen=True)
class Choice:
    """Swarm with one changed setting, or none."""

    loop: Loop
    pilot: Pilot | None = None  # the policy that acts for its robots
    settings: tuple[str, ...] = ()  # the change, as values of `--set`


def write_playground(chosen: EvaluateOptions, file: Path) -> None:
    """Write the page of one or two controllers to a file.

    ConfigError for what does not run in a page: a task other than foraging, a layer that Python
    calls, a controller without estimator. ModuleNotFoundError without ziglang.
    """
    if len(chosen.controllers) > MAX_CONTROLLERS:
        raise ConfigError(
            f"{len(chosen.controllers)} controllers: a page shows at most {MAX_CONTROLLERS}"
        )
    configurations = chosen.configurations()
    first = configurations[0]
    if not isinstance(first.scenario, Scenario):
        raise ConfigError(
            f"scenario '{first.scenario.name}': a page runs foraging scenarios only, such as"
            " es1; watch --html writes a replay of any scenario"
        )
    stage = stage_of(first.scenario, first.label)
    every = max(1, round(FRAME / stage.tick))
    changed = [dict(_changes(each)) for each in configurations]
    possible = (_slider(name, configurations, changed) for name in WORDS)
    sliders = [each for each in possible if each]
    swarms = zip(configurations, changed, strict=True)
    programs = [program_of(each, sliders, own, every) for each, own in swarms]
    known, changes = leaves(first.scenario.model_dump()), parse_settings(chosen.settings)
    full = with_full_names(changes, known, "scenario parameter")
    sets = [shlex.quote(f"--set={name}={value}") for name, value in full.items()]
    command = shlex.join(["swarm-forage", "evaluate", chosen.scenario]), sets
    replays = [_recorded(each, every) for each in configurations]
    page = playground(stage, command, programs, sliders, COLUMNS, every, replays)
    write_atomically(file, page.encode())


def _recorded(configuration: ExperimentConfig, every: int) -> Recording:
    """Record the first minutes of the episode of seed 0, for browsers without WebAssembly."""
    loop = Loop(configuration.scenario, configuration.controller, [0], "kinematic")
    recording = Recording()
    recording.add(loop.scene())
    for _ in range(min(round(RECORDED / FRAME), loop.world.scenario.n_ticks // every)):
        loop.run(every)
        recording.add(loop.scene())
    return recording


Changes = Mapping[tuple[str, float], Choice]
"""Changed swarms by the name of the setting and its value."""


def _changes(configuration: ExperimentConfig) -> Iterator[tuple[tuple[str, float], Choice]]:
    """Yield the swarm with each value of each setting that a visitor changes, unless refused."""
    usual = _changed(configuration, {})
    for name in WORDS:
        now = _number(configuration, name)
        if now is None:
            continue
        multiples = (float(f"{factor * now:.3g}") for factor in FACTORS)
        for value in sorted({*VALUES.get(name, multiples), now}):
            if value == now:
                yield (name, value), usual
                continue
            for settings in _settings(configuration, name, value):
                try:
                    made = _changed(configuration, settings)
                except ConfigError:
                    continue
                if _records(made.loop) == _records(usual.loop):
                    yield (name, value), made
                break


def _number(configuration: ExperimentConfig, name: str) -> float | None:
    if name == OBSTACLES:
        return None if configuration.scenario.obstacles else 0
    known = leaves(configuration.scenario.model_dump()) | configuration.controller.parameters
    value = known.get(name)
    if name == ROBOTS:
        return value
    return float(f"{value:.3g}") if isinstance(value, float) else None


def _settings(
    configuration: ExperimentConfig, name: str, value: float
) -> Iterator[Mapping[str, object]]:
    """Yield alternative settings that make a change; the first one that is accepted applies."""
    scenario = configuration.scenario
    if name == OBSTACLES:
        yield {name: json.dumps([_wall(scenario, side) for side in (-1, 1)])}
        return
    yield {name: value}
    radius = scenario.task.start_radius
    while name == ROBOTS and radius < scenario.task.area_distance:
        radius = float(f"{radius * GROWTH:.3g}")
        yield {name: value, "task.start_radius": radius}


def _wall(scenario: Scenario, side: int) -> dict[str, object]:
    nearest, farthest = scenario.task.start_radius, 0.5 * scenario.task.area_distance
    x = round(side * 0.5 * (nearest + farthest - scenario.task.area_radius), 3)
    half = 0.5 * WALL["length"]
    return {"points": [[x, -half], [x, half]], "radius": WALL["radius"]}


def _changed(configuration: ExperimentConfig, changes: Mapping[str, object]) -> Choice:
    """Return the swarm with these changes; ConfigError if they are refused."""
    scenario, controller = configuration.scenario, configuration.controller
    settings: tuple[str, ...] = ()
    if changes.keys() <= {*CONTROLLER_PARAMETERS}:
        own = {name: value for name, value in changes.items() if name in controller.parameters}
        controller = controller.with_parameters(own)
    else:
        settings = tuple(f"{name}={value}" for name, value in changes.items())
        scenario = find_scenario(scenario, changes)
    pilot, layers = pilot_and_layers(controller, scenario)
    loop = Loop(scenario, layers, [0], "kinematic")
    if not loop.controller.compiled.has_beliefs:
        raise ConfigError(
            f"controller '{controller.name}': a page draws the beliefs of robots, and with a"
            " policy of learn='everything' they have no estimator; use a policy of the motion or"
            " of the weighting"
        )
    return Choice(loop, pilot, settings)


def _records(loop: Loop) -> tuple[object, ...]:
    """Return what machine code depends on; swarms with equal values share their machine code."""
    arrays = *memory_of(loop), *loop.controller.compiled.firsts
    return [each.dtype for each in arrays], _scenario(loop).radio.slots


def _slider(
    name: str, configurations: Sequence[ExperimentConfig], changed: Sequence[Changes]
) -> Slider | None:
    """Return a slider of the values that no swarm refuses; None if there are fewer than two."""
    of_each = [{value for changed_name, value in own if changed_name == name} for own in changed]
    values = sorted(set.intersection(*filter(None, of_each))) if any(of_each) else []
    if len(values) < 2:
        return None
    numbers = (_number(each, name) for each in configurations)
    usual = next(now for now in numbers if now is not None)
    swarm = next(own for own, known in zip(changed, of_each, strict=True) if known)
    choices = [swarm[name, value] for value in values]
    return Slider(
        name,
        WORDS[name][0],
        tuple(_words(name, value) for value in values),
        tuple(values),
        values.index(usual),
        tuple(each.settings for each in choices),
        tuple(_shown(_scenario(each.loop), name) for each in choices),
    )


def _words(name: str, value: float) -> str:
    if name == OBSTACLES:
        return "two walls" if value else "none"
    unit = WORDS[name][1]
    return f"{100 * value:g} %" if unit == "%" else f"{value:g} {unit}".strip()


def _shown(scenario: Scenario, name: str) -> dict[str, object]:
    """Return the drawn properties of a scenario that a change of this setting affects."""
    if name == ROBOTS:
        return {"robots": scenario.task.n_robots, "startRadius": scenario.task.start_radius}
    if name == LIARS:
        return {"hasFaults": scenario.faults.is_any}
    if name == OBSTACLES:
        return {"obstacles": obstacles_shown(stage_of(scenario, "").obstacles)}
    return {}


def program_of(
    configuration: ExperimentConfig, sliders: Sequence[Slider], changed: Changes, every: int
) -> Program:
    """Return a swarm as machine code, with its initial memory and the patches of the sliders."""
    chosen = _changed(configuration, {})
    usual = chosen.loop
    widest = _widest([usual, *(each.loop for each in changed.values())])
    memory = _memory(chosen, every, widest)
    image = _image(memory, usual)
    patches = {
        each.name: [
            list(_patch(image, _image(_memory(changed[each.name, value], every, widest), usual)))
            if (each.name, value) in changed and k != each.usual  # the usual value is rounded
            else []
            for k, value in enumerate(each.values)
        ]
        for each in sliders
    }
    return Program(
        configuration.label,
        colour_of(configuration.label),
        linked_for_web(_text(chosen, memory, every)),
        image.tobytes(),
        [_place(name, array, usual) for name, array in memory.items()],
        [memory[name].shape[axis] for name, (axis, _) in WIDTHS.items()],
        patches,
        [name for name in CONTROLLER_PARAMETERS if name in configuration.controller.parameters],
        _driving(usual),
    )


def _widest(loops: Sequence[Loop]) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of `WIDTHS` that have room for all of these swarms."""
    arrays = [dict(zip(WORLD, loop.world.arrays, strict=True)) for loop in loops]
    return {
        name: tuple(int(size) for size in np.max([each[name].shape for each in arrays], axis=0))
        for name in WIDTHS
    }


INITIAL_ARRAYS = (
    "worlds", "cells", "obstacles", "settings", "modes", "first_robot", "first_mind",
    "first_memory", "spans", "bound", "squashes", *READ_ONLY_ARRAYS,
)  # fmt: skip
"""Arrays of a page that are not zero in a new world; they have the same size for any swarm."""

ROBOT_ARRAYS = (
    "robots", "near", "rewards", "faults", "minds", "memories", "shared", "places", "poses",
    "columns", "pilot_actions", "pilot_raw", "pilot_frames", "pilot_seen",
)  # fmt: skip
"""Arrays whose second axis is that of the robots."""

VIEWS = {"robot_words": "robots", "mind_words": "minds"}  # arrays in the memory of another


def _memory(swarm: Choice, every: int, widest: Mapping[str, tuple[int, ...]]) -> dict[str, Array]:
    """Return the arrays of a page by name, in the order of the arguments of the machine code."""
    loop = swarm.loop
    n, form = loop.world.n_robots, _form(loop)
    own = dict(zip((*WORLD, *LAYERS, "modes", "errors"), memory_of(loop), strict=True))
    own["modes"][...] = START
    for name, fill in {"cells": EMPTY, "obstacles": 0}.items():
        wide = np.full(widest[name], fill, own[name].dtype)
        wide[tuple(map(slice, own[name].shape))] = own[name]
        own[name] = wide
    own["near"] = np.zeros((1, n, widest["near"][2]), np.int32)
    first_robot, seeds, places, poses = loop.world.starts
    first_mind, first_memory = loop.controller.compiled.firsts
    kinds = own["robots"].dtype, own["minds"].dtype
    minds = np.dtype([("estimator", kinds[1])])
    *_, bound, squashes = form.scaling
    pilot = swarm.pilot and swarm.pilot.arrays(n, *kinds, np.arange(widest["near"][1]))
    return {
        **own,
        "first_robot": first_robot,
        "first_mind": first_mind,
        "first_memory": first_memory,
        "seeds": seeds,
        "places": places,
        "poses": poses,
        "columns": np.zeros((len(COLUMNS), n), np.float32),
        "pairs": np.zeros((every * n * n, 2), np.int32),
        "robot_words": own["robots"].view(np.float32),
        "mind_words": own["minds"].view(np.float32),
        "spans": spans_of(form.shown, {"robots": own["robots"].dtype, "minds": minds}),
        "learners": np.zeros(1, np.int64),
        "bound": bound,
        "squashes": squashes.view(np.uint8),
        "no_additions": np.zeros((0, 2), np.int64),
        "time_left": np.zeros(1),
        "raw": np.zeros((1, 1, len(form.policy.action)), np.float32),
        "frames": np.zeros((1, 1, 0, len(form.layout)), np.float32),
        "seen": np.zeros((1, 1, len(form.layout)), np.float32),
        **(pilot or {}),
    }


def _form(loop: Loop) -> PolicyForm:
    """Return the observation and action of a visitor who drives: those of a learned motion."""
    return PolicyForm([loop.world.scenario], EnvConfig(learn="motion"))


def _scenario(loop: Loop) -> Scenario:
    return cast(Scenario, loop.world.scenario)


def _initial_arrays(loop: Loop) -> tuple[str, ...]:
    """Return the names of the arrays of an image; with `faults` if the scenario names robots."""
    is_named = any(kind.robots for _, kind in _scenario(loop).faults)
    return (*INITIAL_ARRAYS, "faults") if is_named else INITIAL_ARRAYS


def _image(memory: Mapping[str, Array], usual: Loop) -> UInt8[Array, " bytes"]:
    """Return the initial memory of a world: the bytes of its kept arrays, concatenated."""
    arrays = (memory[name] for name in memory if name in _initial_arrays(usual))
    return np.frombuffer(b"".join(each.tobytes() for each in arrays), np.uint8)


def _patch(usual: UInt8[Array, " bytes"], other: UInt8[Array, " bytes"]) -> Iterator[Patch]:
    """Yield the position and the new bytes of each difference between two images."""
    edges = np.flatnonzero(np.diff(usual != other, prepend=False, append=False))
    for first, last in edges.reshape(-1, 2):
        yield int(first), other[first:last].tobytes()


def _place(name: str, array: Array, usual: Loop) -> ArrayPlace:
    """Return the size of an array in the memory of a page, for any number of robots."""
    if name in VIEWS:
        return ArrayPlace(name, same=VIEWS[name])
    if name in _initial_arrays(usual):
        return ArrayPlace(name, array.nbytes, is_kept=True)
    power = 2 if name == "pairs" else len(_axes_of_robots(name, array))
    size = array.nbytes // usual.world.n_robots**power
    return ArrayPlace(name, **{("fixed", "per_robot", "per_pair")[power]: size})


def _axes_of_robots(name: str, array: Array) -> tuple[int, ...]:
    if name in ("pilot_states", "pilot_robots"):
        return (0,)
    if name == "shared" and array.ndim > 3:
        return 1, 2
    return (1,) if name in ROBOT_ARRAYS else ()


def _shape(name: str, array: Array, n: int, every: int) -> str:
    """Return the shape of an array of n robots as an expression of `n_robots`."""
    if name == "pairs":
        return f"({every} * n_robots * n_robots, 2)"
    if name in VIEWS:
        return f"(1, n_robots * {array.shape[1] // n})"
    sizes = [str(size) for size in array.shape]
    for axis in _axes_of_robots(name, array):
        sizes[axis] = "n_robots"
    if name in WIDTHS:
        axis, number = WIDTHS[name]
        sizes[axis] = number
    return f"({', '.join(sizes)},)"


WIDTHS = {"near": (2, "n_near"), "cells": (1, "n_cells"), "obstacles": (1, "n_capsules")}
"""Axis and argument of arrays whose width is an argument: scenarios share machine code."""


def _text(swarm: Choice, memory: Mapping[str, Array], every: int) -> str:
    """Return the LLVM text of the ticks of a page and of the drawing after them."""
    usual, pilot = swarm.loop, swarm.pilot
    world, layers = usual.world, usual.controller.compiled
    functions = {**world.functions, **layers.functions}
    own = {
        "pilot": nothing if pilot is None else pilot.kernel,
        "run_ticks": ticks_of(usual),
        "begin_worlds": bind(begin_worlds, functions),
        "observe": bind(observe, {}),
    }
    direction, direction_to, has_walk, *_ = _form(usual).scaling
    shapes = {name: _shape(name, array, world.n_robots, every) for name, array in memory.items()}
    numbers = "n_robots", *(number for _, number in WIDTHS.values()), "n_ticks"
    call = CALL.format(
        world=", ".join(WORLD),
        layers=", ".join(LAYERS),
        noise=layers.noise,
        scaling=f"{direction}, {direction_to}, {has_walk}, bound, squashes",
        piloting="n_robots" if pilot is None else pilot.argument_expression,
    )
    return llvm_text_of(bind(run_and_draw, own), memory, numbers, call, types.int64, shapes)


CALL = (  # call of the compiled function with the arrays of a page
    "called(({world},), ({layers},), modes, errors,"
    " (first_robot, first_mind, first_memory, seeds, places, poses), {noise}, n_ticks, columns,"
    " pairs, ((robot_words, mind_words, robot_words, spans, n_robots), learners, ({scaling}),"
    " (no_additions, time_left, raw), (seen, frames, seen)), ({piloting},))"
)


def _driving(usual: Loop) -> Driving:
    """Return where a robot's record holds a visitor's commands, and the features observed."""
    robots, form = usual.world.robots.dtype, _form(usual)
    robot = np.zeros(1, robots)
    layers = {"weighting": np.zeros(1, np.bool_), "motion": np.ones(1, np.bool_)}
    form.mark_replaced_layers(robot["action"], layers)
    at = offset_of(robots, "action")
    return Driving(
        robots.itemsize,
        at,
        robot["action"].tobytes(),
        offset_of(robots["action"], "wheels"),
        [(each.name, each.unit, each.low) for each in form.layout],
    )
