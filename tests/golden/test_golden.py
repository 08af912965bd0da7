"""The swarm does what it did: bit for bit, in every quantity, at every tick.

A change that is meant to change results records them anew: `make golden`.
"""

import pytest
from numba import config

from tests.golden.cases import all_cases
from tests.golden.record import DATA, MACHINE, differences, load, record

CASES = all_cases()
GOLDEN = load()
RECORDED_ON = (DATA / "machine.txt").read_text(encoding="utf-8").strip()

pytestmark = [
    pytest.mark.skipif(MACHINE != RECORDED_ON, reason=f"recorded on {RECORDED_ON}"),
    pytest.mark.skipif(bool(config.DISABLE_JIT), reason="takes hours in plain Python"),
]

SHORT = {
    **{name: 100 for name in CASES if name.startswith("es1/")},
    **{name: 40 for name in CASES if name.startswith("waypoints-25/boids-adaptive")},
    **{name: 40 for name in CASES if name.startswith("waypoints-05-authors/boids-adaptive")},
    **{name: 40 for name in CASES if name.startswith(("parallel/waypoints", "learner/waypoints"))},
    **{name: 200 for name in CASES if "es1-busy/learn=" in name and "controller" not in name},
    **{name: 200 for name in CASES if name.startswith("es1-busy/")},
    **{name: 200 for name in CASES if name.startswith(("es1-faulty/", "two-prey-moving/"))},
    **{name: 100 for name in CASES if name.startswith("mg1-")},
    **{name: 100 for name in CASES if "learners=" in name or "randomise=" in name},
    "es3/rigid/ssgikf": 100,
    "es3/kinematic/ssgikf": 100,
}
"""The first ticks of some cases: each controller, engine, estimator, layer to learn and fault."""


def compare(name, length=None):
    lines = differences(GOLDEN[name], record(CASES[name], length))
    assert not lines, f"{name}: " + "; ".join(lines)


def test_every_case_is_recorded():
    assert CASES.keys() == GOLDEN.keys(), "the cases have changed: run `make golden`"


@pytest.mark.parametrize("name", SHORT)
def test_the_swarm_begins_as_it_did(name):
    compare(name, SHORT[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_swarm_does_what_it_did(name):
    compare(name)
