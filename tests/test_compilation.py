"""Compiled, plain and bounds-checked kernels do the same; memory stays where it is."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]

RUN = """
import sys
import numpy as np
import baselines.recipes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.scenarios import find_scenario

file, scenario, controller, physics, ticks = sys.argv[1:]
kept = {"pose": [], "odometry": [], "proximity": [], "ground": [], "beam": [], "words": []}
with np.errstate(over="ignore"):  # 64-bit words are meant to overflow
    loop = ControlLoop(find_scenario(scenario), find_controller(controller), [5], physics)
    for tick in range(int(ticks)):
        seen = loop.step()
        kept["pose"].append(loop.world.state.pose.copy())
        for name in ("odometry", "proximity", "ground"):
            kept[name].append(getattr(seen.readings, name))
        for name in ("beam", "words"):
            kept[name].append(getattr(seen.heard, name))
np.savez(file, **kept)
"""

MEMORY = """
import resource
import baselines.recipes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.scenarios import find_scenario

scenario = find_scenario("es1")
loop = ControlLoop(scenario, find_controller("ssgiff"), [5], "rigid")
peak = []
for ticks in (4000, 20000):
    for _ in range(ticks):
        loop.step()
    peak.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
print(peak[1] / peak[0] - 1.0)
"""


def run(script, *arguments, **variables):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        env=environment, capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def trajectory(file, *arguments, **variables):
    run(RUN, file, *arguments, **variables)
    with np.load(file) as kept:
        return dict(kept)


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_compiled_and_plain_kernels_agree(tmp_path, physics):
    what = ("es1", "dsgiff", physics, 60)
    compiled = trajectory(tmp_path / "compiled.npz", *what)
    plain = trajectory(tmp_path / "plain.npz", *what, NUMBA_DISABLE_JIT="1")
    # Layers hand over float32: a last bit of a sine may round one of them the other way, and
    # an infrared reading near contact makes ten of such a difference.
    for name, values in compiled.items():
        np.testing.assert_allclose(plain[name], values, rtol=0.0, atol=1e-5, err_msg=name)


def test_no_kernel_reads_beyond_its_arrays(tmp_path):
    checked = trajectory(
        tmp_path / "checked.npz", "es2", "dsgikf", "rigid", 300, NUMBA_BOUNDSCHECK="1"
    )
    assert np.isfinite(checked["pose"]).all()


def test_memory_is_flat():
    assert float(run(MEMORY, SWARM_CHECK_SHAPES="")) < 0.01
