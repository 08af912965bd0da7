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
        ({"discrete": True, "learners": 2, "reward": "team", "shaping": 1.0}, [1, 1]),
    ],
    ids=["numbers", "choices"],
)
def test_the_environment_of_torchrl_does_what_it_does_on_a_cpu(options, ends):
    pytest.importorskip("torchrl")
    assert run(TORCHRL, repr({**SMALL, **options})).splitlines()[-1] == f"{ends} True"


SB3 = """
import sys
import numpy as np
from training.vec_env import SwarmVecEnv

def same(mine, his):
    for one, other in zip(mine, his, strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)

def drawn(rng, space, n):
    if not space.shape:
        return rng.integers(space.n, size=n)
    return rng.uniform(space.low, space.high, (n, *space.shape)).astype(np.float32)

options = {"n_worlds": 2, "seed": 3, "stagger": True, **eval(sys.argv[1])}
cpu, gpu = (SwarmVecEnv("es1", device=device, **options) for device in ("cpu", "cuda"))
same([cpu.reset()], [gpu.reset()])
rng, space, ends = np.random.default_rng(1), cpu.action_space, []
for step in range(5):
    actions = drawn(rng, space, cpu.num_envs)
    *mine, infos = cpu.step(actions)
    *his, told = gpu.step(actions)
    same(mine, his)
    for one, other in zip(infos, told, strict=True):
        assert one.keys() == other.keys()
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])
    ends.append(sum("round_trips" in info for info in told))
try:
    gpu.step(np.full((gpu.num_envs, *space.shape), np.nan if space.shape else 99))
except ValueError as error:
    print(ends, error)
"""


@pytest.mark.parametrize(
    ("options", "refused"), [({}, "nan"), ({"discrete": True, "shaping": 1.0}, "99")]
)
def test_the_vector_environment_of_sb3_does_what_it_does_on_a_cpu(options, refused):
    pytest.importorskip("stable_baselines3")
    told = run(SB3, repr({**SMALL, **options})).splitlines()[-1]
    assert told.startswith("[0, 3, 3, 0, 3] ")
    assert refused in told
