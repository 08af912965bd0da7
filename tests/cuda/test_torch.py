"""Tensors of torch over worlds on the grid, in numba's simulator: as over those of a CPU."""

import pytest

from tests.cuda.test_simulator import run

pytestmark = [pytest.mark.cuda, pytest.mark.filterwarnings("ignore")]

SMALL = {"physics": "kinematic", "task.n_robots": 3, "max_cycles": 3, "decision_period": 2}

TORCHRL = """
import sys
import torch
from torchrl.envs import check_env_specs
from training.torchrl_env import SwarmTorchEnv

def rollout(env):
    env.set_seed(4)
    torch.manual_seed(4)
    return env.rollout(5, break_when_any_done=False)

options = {"n_worlds": 2, "return_state": False, **eval(sys.argv[1])}
cpu, gpu = (SwarmTorchEnv(device=device, **options) for device in ("cpu", "cuda"))
check_env_specs(SwarmTorchEnv(device="cuda", **options), seed=0)
mine, his = rollout(cpu), rollout(gpu)
assert set(mine.keys(True, True)) == set(his.keys(True, True))
for key in mine.keys(True, True):
    assert mine[key].dtype == his[key].dtype, key
    assert torch.equal(mine[key], his[key]), key
assert {k: v.tolist() for k, v in cpu.episodes(mine).items()} == {
    k: v.tolist() for k, v in gpu.episodes(his).items()
}
print(his["next", "done"].sum(1).flatten().tolist(), gpu.has_render)
"""


@pytest.mark.parametrize(
    ("options", "ends"),
    [
        (
            {"learn": "motion", "stagger": True, "randomise": {"radio.max_range": (0.1, 0.2)}},
            [2, 1],
        ),
        ({"learn": "weighting", "learners": 2, "reward": "team"}, [1, 1]),
    ],
    ids=["motion", "weighting"],
)
def test_the_environment_of_torchrl_does_what_it_does_on_a_cpu(options, ends):
    pytest.importorskip("torchrl")
    assert run(TORCHRL, repr({**SMALL, **options})).splitlines()[-1] == f"{ends} True"
