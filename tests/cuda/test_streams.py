"""Streams of CUDA: all that a GPU is asked to do is in the order of the one that was chosen."""

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
env._on.check()
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
    assert refusal.startswith("stream='default': must be the address of a stream of CUDA")


def test_tensors_of_torch_are_made_in_its_current_stream():
    pytest.importorskip("torchrl")
    assert run(TORCH).splitlines() == ["[0]", "[5]", "[6]", "[5]", "[6]"]
