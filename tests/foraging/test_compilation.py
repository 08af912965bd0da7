"""Compiled, plain and bounds-checked kernels do the same."""

import numpy as np
import pytest

from tests.scripts import run_python

START = """
import sys
import numpy as np
import baselines.controllers
import swarm_forage_env.foraging.named
import swarm_forage_env.foraging.task
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
"""

RUN = (
    START
    + """
file, scenario, controller, physics, ticks = sys.argv[1:]
loop = Loop(find_scenario(scenario), CONTROLLERS[controller], [5], physics)
beliefs = loop.controller.minds["estimator"]["belief"]
rng = np.random.default_rng(3)  # everybody knows something, and tells it from the first tick on
beliefs["known"] = beliefs["visited"] = rng.integers(0, 2, beliefs["known"].shape)
beliefs["location"] = rng.uniform(-1.0, 1.0, beliefs["location"].shape)
beliefs["p"] = rng.uniform(0.0, 3.0, beliefs["p"].shape)
kept = {}
for tick in range(int(ticks)):
    loop.step()
    for records, names in (
        (loop.world.robots, ("pose", "wheels", "messages")),
        (loop.world.robots["readings"], ("odometry", "proximity", "ground")),
        (beliefs, ("pose", "location", "p", "known", "goal", "partner", "heard_sum")),
        (loop.controller.minds["estimator"]["exchange"], ("is_valid", "weight", "disagreement")),
    ):
        for name in names:
            kept.setdefault(f"{len(records.dtype)} {name}", []).append(records[name].copy())
np.savez(file, **kept)
"""
)


def trajectory(file, *arguments, **variables):
    run_python("-c", RUN, file, *arguments, **variables)
    with np.load(file) as kept:
        return dict(kept)


@pytest.mark.parametrize(
    "what",
    [
        ("es1", "dsgiff", "rigid"),
        ("es1", "ssgikf", "kinematic"),
        ("mg1-hexagon", "ssgikf", "rigid"),
    ],
)
def test_compiled_and_plain_kernels_agree(tmp_path, what):
    compiled = trajectory(tmp_path / "compiled.npz", *what, 30)
    plain = trajectory(tmp_path / "plain.npz", *what, 30, NUMBA_DISABLE_JIT="1")
    assert any(values.any() for name, values in compiled.items() if name.endswith("is_valid"))
    for name, values in compiled.items():
        # Layers hand over float32: a last bit of a sine may round one of them the other way, of
        # both frames of a message, and an infrared reading near contact makes forty of such a
        # difference.
        atol = 1e-5 if name.endswith("proximity") else 1e-6
        rtol = 2.0 * np.finfo(np.float32).eps
        np.testing.assert_allclose(plain[name], values, rtol=rtol, atol=atol, err_msg=name)


@pytest.mark.parametrize("scenario", ["es2", "mg1-hexagon"])
def test_no_kernel_reads_beyond_its_arrays(tmp_path, scenario):
    checked = trajectory(
        tmp_path / "checked.npz", scenario, "dsgikf", "rigid", 300, NUMBA_BOUNDSCHECK="1"
    )
    for name, values in checked.items():
        assert np.isfinite(values).all(), name
