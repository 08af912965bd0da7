"""Streams of CUDA and tensors over worlds on the grid, in numba's simulator of a GPU."""

import pytest

from tests.cuda.test_simulator import run

pytestmark = [pytest.mark.cuda, pytest.mark.filterwarnings("ignore")]

RECORDED = """
import sys
import numpy as np
import numba.cuda as cuda
from numba.cuda.simulator.cudadrv import devicearray
from numba.cuda.simulator.kernel import FakeCUDAKernel
import baselines.controllers
from swarm_forage_env import array_env

asked, events = [], []

class Stream:
    def __init__(self, address):
        self.address = address

class Event:
    def record(self, stream=0):
        events.append(("after", stream))

    def wait(self, stream=0):
        events.append(("goes on", stream))

def noted(function):
    def call(*arguments, stream=0, **options):
        asked.append((function.__name__, stream))
        return function(*arguments, stream=stream, **options)
    return call

def launched(kernel, on):
    free = dict(zip(kernel.fn.__code__.co_freevars, kernel.fn.__closure__))
    asked.append((free["function"].cell_contents.__name__, on[2] if len(on) > 2 else 0))
    return configured(kernel, on)

configured, FakeCUDAKernel.__getitem__ = FakeCUDAKernel.__getitem__, launched
cuda.external_stream, cuda.event = Stream, Event
for name in ("to_device", "device_array"):
    setattr(cuda, name, noted(getattr(cuda, name)))
for name in ("copy_to_host", "copy_to_device"):
    setattr(devicearray.FakeCUDAArray, name, noted(getattr(devicearray.FakeCUDAArray, name)))

def streams():
    found = {getattr(stream, "address", stream) for _, stream in asked}
    names = {name for name, _ in asked}
    asked.clear()
    return sorted(found), names
"""

EVERYTHING = (
    RECORDED
    + """
env = array_env(
    "es1", device="cuda", n_worlds=2, physics="kinematic", max_cycles=2, stack=2, shaping=0.5,
    observation=["layer", "time_left"], randomise={"radio.max_range": (0.1, 0.2)},
    **{"task.n_robots": 2},
)
env.reset(seed=0)
print(streams()[0], env.stream, events)
env.stream = 77
for step in range(2):
    told = env.step(env.memory.to_device(np.zeros((2, 2, 2), np.float32)))
env.reset(worlds=env.is_over)
env.log(), env.download(), env.memory.mark()
found, names = streams()
print(found, sorted(names))
print([(what, getattr(stream, "address", stream)) for what, stream in events], env.stream)
env.stream = 77
env.stream = 0
env._worlds.check()
print(streams()[0], [(what, getattr(stream, "address", stream)) for what, stream in events[3:]])
try:
    env.stream = "default"
except ValueError as error:
    print(error)
"""
)

TORCH = (
    RECORDED
    + """
from types import SimpleNamespace
import torch
from training.tensor_vec_env import TensorVecEnv
from training.torchrl_env import SwarmTorchEnv

def in_stream(address):
    torch.cuda.is_initialized = lambda: True
    torch.cuda.current_stream = lambda gpu: SimpleNamespace(cuda_stream=address)

options = {"n_worlds": 2, "physics": "kinematic", "max_cycles": 2, "task.n_robots": 2}
tensors = TensorVecEnv([array_env("es1", device="cuda", **options)])
envs = SwarmTorchEnv("es1", device="cuda", return_state=False, **options)
print(streams()[0])
for begin, step in (
    (lambda: tensors.reset(), lambda: tensors.step(torch.zeros((4, 2)))),
    (lambda: envs.reset(), lambda: envs.rand_step(envs.reset())),
):
    in_stream(5)
    begin()
    print(streams()[0])
    in_stream(6)
    step()
    print(streams()[0])
"""
)


def test_every_launch_and_copy_is_in_the_stream_that_was_chosen():
    first, later, changes, back, refusal = run(EVERYTHING).splitlines()
    assert first == "[0] 0 []"
    asked, _, names = later.partition("] [")
    assert asked == "[77"
    for each in (
        "decide_at_once", "run_ticks", "observe", "write_log", "begin_worlds", "to_device",
        "device_array", "copy_to_host", "copy_to_device",
    ):  # fmt: skip
        assert f"'{each}'" in names, each
    assert changes == "[('after', 0), ('goes on', 77), ('after', 77)] 77"
    assert back == "[0] [('after', 77), ('goes on', 0)]"
    assert refusal.startswith("stream='default': must be the address of a CUDA stream")


def test_tensors_of_torch_are_made_in_its_current_stream():
    pytest.importorskip("torchrl")
    assert run(TORCH).splitlines() == ["[0]", "[5]", "[6]", "[5]", "[6]"]


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
