"""The golden cases of a GPU: worlds on it, read as those of a CPU."""

from dataclasses import replace
from functools import partial

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.scenarios import find_scenario
from tests.cuda.conftest import ON_GRID
from tests.golden import readout
from tests.golden.cases import SEEDS, all_cases
from tests.golden.record import Recording, differences, load, record

CASES = {
    name: case
    for name, case in all_cases().items()
    if case.kind == "foraging" and name.split("/")[1:] in [["kinematic", each] for each in ON_GRID]
}

READ = "pose", "beliefs", "rewards", "scores"
"""Quantities that can be read after a tick: messages are composed within it."""


def play(case, n_ticks, take):
    """A block of worlds for so many ticks on a GPU."""
    scenario, controller, physics, numbers = case.play.args
    what = find_scenario(scenario, numbers), find_controller(controller), SEEDS, physics
    gpu = DeviceLoop(readout.ForagingLoop(*what, 1, True))
    gpu.reset(SEEDS)
    for tick in range(n_ticks + 1):
        if tick:
            gpu.step()
        there = gpu.download()
        there.known = there.world.state.known
        read = readout.readout(there)
        take({name: read[name] for name in READ})
    gpu.check()
    return readout.results(there)


def differences_on_grid(name, length=None):
    """Where a case on a GPU, or the first ticks of it, differs from what was recorded."""
    golden, case = load()[name], CASES[name]
    kept = {quantity: golden.checksums[quantity] for quantity in READ}
    found = record(replace(case, play=partial(play, case)), length)
    return differences(Recording(kept, golden.results), found)
