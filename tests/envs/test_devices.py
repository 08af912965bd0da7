"""Where the worlds of an environment run, and what does not run on a GPU."""

import importlib.util

import pytest

from swarm_forage_env import ConfigError, array_env
from tests.envs.test_observations import Compass

GPU = {"device": "cuda", "physics": "kinematic"}


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"device": "tpu"}, "device='tpu': must be 'cpu' or 'cuda'"),
        ({"device": "cuda", "physics": "rigid"}, "rigid calls a library that runs on a CPU only"),
        ({**GPU, "observation": ["layer", Compass]}, "observation: Compass is written in NumPy"),
        ({**GPU, "reward": lambda before, after, events: events["trip"]}, "reward=.*CPU only"),
        ({**GPU, "scenario": "waypoints-05"}, "the task waypoints runs on a CPU only"),
        ({**GPU, "controller": "boids-goal"}, "'boids-goal' runs on a CPU only"),
        ({**GPU, "controller": ["ssgikf"] * 5 + ["sikf"] * 5}, "several teams"),
    ],
)
def test_what_does_not_run_on_a_gpu_is_refused_with_the_reason(options, complaint):
    with pytest.raises(ConfigError, match=complaint):
        array_env(**{"scenario": "es1", **options})


@pytest.mark.skipif(importlib.util.find_spec("numba_cuda") is not None, reason="it is installed")
def test_a_gpu_needs_its_compiler():
    with pytest.raises(ConfigError, match=r"needs numba-cuda; pip install 'swarm-forage\[cuda\]'"):
        array_env("es1", **GPU)


def test_a_cpu_has_no_stream_and_takes_that_of_a_gpu():
    env = array_env("es1", physics="kinematic")
    env.stream = 77
    assert env.stream == 0
