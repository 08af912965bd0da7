"""One hash on CPU and GPU: worlds do there what was recorded on a CPU, at every tick."""

import pytest

from tests.cuda.conftest import COMPILED
from tests.cuda.on_grid import CASES, differences_on_grid
from tests.cuda.test_simulator import run
from tests.golden.test_golden import MACHINE, RECORDED_ON

pytestmark = pytest.mark.skipif(MACHINE != RECORDED_ON, reason=f"recorded on {RECORDED_ON}")

FEW = (
    *(f"es1-busy/kinematic/{controller}" for controller in COMPILED),
    *(f"{world}/kinematic/ssgikf" for world in ("es3", "es1-faulty", "mg1-square")),
    "two-prey-moving/kinematic/ssgikf",
)
"""Every composition, and every kind of world; all others are run with those that are slow."""

SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in CASES if name not in FEW]

SCRIPT = """
import sys
from tests.cuda.on_grid import differences_on_grid
print(differences_on_grid(sys.argv[1], 5))
"""


@pytest.mark.gpu
@pytest.mark.parametrize("name", [*FEW, *SLOW])
def test_the_swarm_does_on_a_gpu_what_it_did_on_a_cpu(name):
    assert differences_on_grid(name) == []


@pytest.mark.cuda
def test_the_swarm_begins_on_the_grid_as_it_did_on_a_cpu():
    assert run(SCRIPT, "es1-busy/kinematic/ssgikf") == "[]"
    assert run(SCRIPT, "es1-faulty/kinematic/learned-both") == "[]"
