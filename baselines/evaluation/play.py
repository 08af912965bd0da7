"""What a playground consists of: controllers as WebAssembly, worlds that begin, and sliders."""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba.core import types

from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.plot_style import colour_of
from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.compiler import bind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.drawing import COLUMNS, run_and_draw
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import leaves
from swarm_forage_env.rendering.playground import Patch, Program, Slider, playground
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.targets import handed_over, linked_for_web, llvm_text_of, memory_of, ticks_of
from swarm_forage_env.task import stage_of

MAX_CONTROLLERS = 2
"""Swarms side by side."""

FRAME = 1.0
"""Time between two frames of a page [s]."""

ALIGNED = 64
"""Every array of a world begins at a multiple of this [byte]."""

OF_SCENARIO = {
    "radio.max_range": ("Radio range", "m"),
    "radio.bearing_noise": ("Bearing noise", "rad"),
    "sensors.wheel_noise": ("Wheel noise", ""),
}
OF_CONTROLLER = {"weighting.beta": ("Beta", "")}
"""The numbers that a visitor changes: what they are called, and their units."""

FACTORS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)
"""Their values, as multiples of the usual one; those that are refused are left out."""


@dataclass(frozen=True)
class Changed:
    """A swarm whose scenario and controller differ in one number, or in none."""

    scenario: Scenario
    controller: Controller


def write_playground(chosen: EvaluateOptions, file: Path) -> None:
    """Write the page of one or two controllers to a file.

    ConfigError for what does not run in a page: another engine than `kinematic`, a task without a
    nest and prey, a layer that Python calls. ModuleNotFoundError without ziglang.
    """
    if len(chosen.controllers) > MAX_CONTROLLERS:
        raise ConfigError(f"{len(chosen.controllers)} controllers: a page shows {MAX_CONTROLLERS}")
    configurations = chosen.configurations()
    first = configurations[0]
    if not isinstance(first.scenario, Scenario):
        raise ConfigError(f"scenario '{first.scenario.name}': a page runs worlds that forage alone")
    stage = stage_of(first.scenario, first.label)
    every = max(1, round(FRAME / stage.tick))
    sliders, programs = sliders_of(configurations), []
    for each in configurations:
        programs.append(program_of(each, sliders, chosen.seeds(), every))
    words = ["swarm-forage", "play", chosen.scenario, *chosen.controllers]
    words += [f"--set={each}" for each in chosen.settings] + [f"--html={file.name}"]
    page = playground(stage, shlex.join(words), programs, sliders, COLUMNS, every)
    write_atomically(file, page.encode())


def sliders_of(configurations: Sequence[ExperimentConfig]) -> list[Slider]:
    """The sliders of a page: numbers of the scenario, and those that a controller has."""
    found = []
    for name, (label, unit) in {**OF_SCENARIO, **OF_CONTROLLER}.items():
        usual = next(filter(None, (_number(each, name) for each in configurations)), None)
        if usual is None:
            continue
        values = [
            value
            for value in (float(f"{factor * usual:.3g}") for factor in FACTORS)
            if value == usual or all(_changed(each, name, value) for each in configurations)
        ]
        found.append(Slider(name, label, unit, tuple(values), values.index(usual)))
    return found


def _number(configuration: ExperimentConfig, name: str) -> float | None:
    """The number of that name; None where there is none."""
    known = leaves(configuration.scenario.model_dump()) | configuration.controller.parameters
    value = known.get(name)
    return float(f"{value:.3g}") if isinstance(value, float) else None


def _changed(configuration: ExperimentConfig, name: str, value: float) -> Changed | None:
    """The swarm with another number; as it is where it has none so; None if that is refused."""
    scenario, controller = configuration.scenario, configuration.controller
    try:
        if name in OF_SCENARIO:
            return Changed(find_scenario(scenario, {name: value}), controller)
        if _number(configuration, name) is None:
            return Changed(scenario, controller)
        return Changed(scenario, controller.with_parameters({name: value}))
    except ConfigError:
        return None


def program_of(
    configuration: ExperimentConfig, sliders: Sequence[Slider], seeds: Sequence[int], every: int
) -> Program:
    """A swarm as machine code, with the memory of its world for each seed."""
    usual = Changed(configuration.scenario, configuration.controller)
    loop = _loop(usual, seeds[0])
    widest = [
        _changed(configuration, each.name, value) for each in sliders for value in each.values
    ]
    for each in filter(None, widest):  # all numbers of neighbours and cells have room
        loop.reset([seeds[0]], scenarios=each.scenario)
    images = [_image(loop, usual, seed) for seed in seeds]
    patches = {
        each.name: [
            []
            if k == each.usual  # which is rounded
            else list(_patch(loop, images, _changed(configuration, each.name, value), seeds))
            for k, value in enumerate(each.values)
        ]
        for each in sliders
    }
    return Program(
        configuration.label,
        colour_of(configuration.label),
        linked_for_web(_text(loop, every)),
        [each.tobytes() for each in images],
        tuple(len(_padded(each)) for each in memory_of(loop)),
        patches,
    )


def _loop(swarm: Changed, seed: int) -> Loop:
    return Loop(swarm.scenario, swarm.controller, [seed], "kinematic")


def _padded(array: Array) -> bytes:
    return array.tobytes() + bytes(-array.nbytes % ALIGNED)


def _image(loop: Loop, swarm: Changed, seed: int) -> UInt8[Array, " bytes"]:
    """The memory of a world that is about to begin, with the widths of the loop's arrays."""
    memory = _beginning(loop, swarm.scenario, seed)
    if swarm.controller is not loop.controllers[0]:
        own = _beginning(_loop(swarm, seed), swarm.scenario, seed)
        layers = slice(len(loop.world.arrays), -2)
        memory[layers] = own[layers]
    return np.frombuffer(b"".join(map(_padded, memory)), np.uint8)


def _beginning(loop: Loop, scenario: Scenario, seed: int) -> list[Array]:
    """The arrays of a loop whose world starts from a seed, before its robots sense anything."""
    numbers = loop.controller.numbers_in(0, scenario)
    loop.world.reset([seed], [0], [scenario])
    loop.controller.renumber(0, numbers)
    loop.controller.reset(0, seed)
    *arrays, _, trouble = memory_of(loop)
    return [*arrays, loop.world.beginning.copy(), trouble]


def _patch(
    loop: Loop,
    images: Sequence[UInt8[Array, " bytes"]],
    swarm: Changed | None,
    seeds: Sequence[int],
) -> Iterator[Patch]:
    """What differs in the memory of a changed swarm, which must be the same for every seed."""
    assert swarm is not None, "a slider has values alone that are not refused"
    others = [_image(loop, swarm, seed) for seed in seeds[:2]]
    differs = others[0] != images[0]
    for other, image in zip(others, images, strict=False):
        assert ((other != image) <= differs).all(), "numbers stand apart from what a seed draws"
        assert (other == others[0])[differs].all(), "a number is the same for every seed"
    edges = np.flatnonzero(np.diff(differs, prepend=False, append=False))
    for first, last in edges.reshape(-1, 2):
        yield int(first), others[0][first:last].tobytes()


def _text(loop: Loop, every: int) -> str:
    """The ticks of a page as LLVM's text, with what is drawn after them."""
    n_robots = loop.world.n_robots
    arrays, passed = handed_over(loop)
    drawn = {
        "columns": np.zeros((len(COLUMNS), n_robots), np.float32),
        "pairs": np.zeros((every * n_robots * (n_robots - 1), 2), np.int32),
    }
    call = f"called({passed}, n_ticks, columns, pairs)"
    called = bind(run_and_draw, {"run_ticks": ticks_of(loop)})
    return llvm_text_of(called, {**arrays, **drawn}, ("n_ticks",), call, types.int64)
