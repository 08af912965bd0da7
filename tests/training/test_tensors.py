"""Tensors over the arrays of environments: where they are, and what cannot be."""

import numpy as np
import pytest
import torch

from swarm_forage_env import ConfigError
from training.tensor_vec_env import tensor_of, torch_device, worlds_on


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
