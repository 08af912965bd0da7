"""Tensors over the arrays of environments: where they are, and what cannot be."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from swarm_forage_env import ConfigError
from training import tensor_vec_env
from training.tensor_vec_env import follow_stream, tensor_of, torch_device, worlds_on


def test_torch_must_find_the_gpu_that_the_worlds_are_on(monkeypatch, experiment):
    for module in ("tensor_vec_env", "experiment"):
        monkeypatch.setattr(f"training.{module}.usable_gpu", lambda: None)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with pytest.raises(ConfigError, match=r"device='cuda': torch .* finds no GPU; install its"):
        torch_device("cuda")
    with pytest.raises(ConfigError, match=r"--device='cuda': torch .* finds no GPU"):
        experiment(layer="motion", algorithm="ppo", population=None, device="cuda").check()
    experiment(device="cuda").check()  # a search needs no torch


def test_worlds_are_on_a_gpu_for_cuda_alone():
    assert [worlds_on(each) for each in ("cpu", "meta", "cuda", "cuda:0")] == [
        "cpu", "cpu", "cuda", "cuda",
    ]  # fmt: skip
    with pytest.raises(ConfigError, match="device='cuda:1': worlds run on the first GPU"):
        worlds_on("cuda:1")
    assert torch_device("cpu") == torch.device("cpu")


def test_a_tensor_shares_the_memory_of_its_array():
    array = np.zeros((2, 3), np.float32)
    tensor_of(array)[1, 2] = 5.0
    assert array[1, 2] == 5.0
    assert tensor_of(np.broadcast_to(np.ones(2), (3, 2))).shape == (3, 2)


class FakeDeviceEnv:
    """An environment of a GPU, as far as tensors ask for it."""

    stream = "its own"
    device = "cuda"
    memory = SimpleNamespace(to_device=lambda array: ("on device", array))


@pytest.fixture
def device_env():
    return FakeDeviceEnv()


def test_tensors_are_where_the_worlds_are(monkeypatch):
    asked = []
    monkeypatch.setattr(tensor_vec_env, "usable_gpu", lambda: asked.append("gpu"))
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(tensor_vec_env, "is_simulated", lambda: False)
    assert torch_device("cpu") == torch.device("cpu")
    assert not asked
    assert torch_device("cuda") == torch.device("cuda")
    monkeypatch.setattr(tensor_vec_env, "is_simulated", lambda: True)
    assert torch_device("cuda") == torch.device("cpu")
    assert asked == ["gpu"] * 2
    with pytest.raises(ConfigError, match="device='tpu'"):
        torch_device("tpu")


def test_worlds_of_a_gpu_follow_the_current_stream_of_the_first(monkeypatch, device_env):
    streams = {0: SimpleNamespace(cuda_stream=1234)}
    monkeypatch.setattr(torch.cuda, "current_stream", streams.__getitem__)
    other = SimpleNamespace(stream="none", device="cpu")
    for began, stream in ((False, "its own"), (True, 1234)):
        monkeypatch.setattr(torch.cuda, "is_initialized", lambda began=began: began)
        follow_stream(device_env)
        follow_stream(other)
        assert (device_env.stream, other.stream) == (stream, "none")
