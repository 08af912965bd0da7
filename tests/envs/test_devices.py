"""Where the worlds of an environment run, and what does not run on a GPU."""

import importlib.util

import numpy as np
import pytest

from swarm_forage_env import ArrayEnv, ConfigError, array_env
from swarm_forage_env.spaces import Feature


class Heading:
    """An observation of the user's own, in NumPy."""

    def features(self, scenario, agents):
        """One number."""
        return [Feature("heading", "rad", -4.0, 4.0)]

    def write(self, moment, out):
        """From the true pose."""
        out[:, :, 0] = moment.robots["pose"][:, :, 2]


GPU = {"device": "cuda", "physics": "kinematic"}


def test_a_cpu_is_the_usual_device():
    env = array_env("es1", n_worlds=2, physics="kinematic")
    assert isinstance(env, ArrayEnv)
    assert env.reset(seed=0)[0].shape[:2] == (2, 10)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"device": "tpu"}, "device='tpu': must be 'cpu' or 'cuda'"),
        ({"device": "cuda", "physics": "rigid"}, "engine rigid runs on a CPU only"),
        ({**GPU, "observation": ["layer", Heading]}, "observation: Heading is written in NumPy"),
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


def test_a_stream_is_taken_where_there_is_none():
    env = array_env("es1", n_worlds=1, physics="kinematic")
    env.stream = 77
    assert env.stream == 0


def test_a_snapshot_that_does_not_fit_changes_nothing():
    env, other = (array_env("es1", learn=learn, stack=2) for learn in ("motion", "both"))
    env.reset(seed=0)
    env.step(np.full((1, 10, 2), 0.5, np.float32))
    before = env.snapshot()
    with pytest.raises(ConfigError, match=r"restore\(\)"):
        env.restore(other.snapshot())
    several = array_env("es1", stack=2, **{"task.duration": 60, "controller": "nc"})
    with pytest.raises(ConfigError, match="cannot be restored"):
        env.restore(several.snapshot())
    (raw, kept), (raw_now, now) = before[1][1], env.snapshot()[1][1]
    for mine, his in zip((raw, *kept), (raw_now, *now), strict=True):
        np.testing.assert_array_equal(mine, his)
