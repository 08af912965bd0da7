"""Wrappers of SuperSuit and Gymnasium that rescale, skip and tell the time go round ours."""

import numpy as np
import pytest
from pettingzoo.test import api_test, parallel_api_test

from swarm_forage_env import env, parallel_env

WHY = "the wrappers need it: pip install supersuit"
frame_skip, agent_indicator, normalize_obs = (
    getattr(pytest.importorskip("supersuit", reason=WHY), name)
    for name in ("frame_skip_v0", "agent_indicator_v0", "normalize_obs_v0")
)

FEW = {"task.n_robots": 3, "max_cycles": 20, "physics": "kinematic"}

WRAPPERS = {
    "frame_skip": lambda made: frame_skip(made, 3),
    "frame_skip at random": lambda made: frame_skip(made, (2, 3)),
    "agent_indicator": agent_indicator,
    "normalize_obs": lambda made: normalize_obs(made, env_min=-1.0, env_max=1.0),
}

every_wrapper = pytest.mark.parametrize("wrap", WRAPPERS.values(), ids=WRAPPERS)


@every_wrapper
def test_pettingzoo_accepts_it_in_parallel(wrap):
    parallel_api_test(wrap(parallel_env("es1", **FEW)), num_cycles=30)


@pytest.mark.parametrize("name", sorted(set(WRAPPERS) - {"frame_skip at random"}))
def test_pettingzoo_accepts_it_in_turn(name):
    api_test(WRAPPERS[name](env("es1", **FEW)), num_cycles=30)


def observed(made, n_steps=150):
    """What the first robot observes in n steps ahead, in bends."""
    seen = [made.reset(seed=0)[0]["epuck_0"]]
    for step in range(n_steps):
        action = np.float32([1.0, np.sin(step / 9.0)])
        seen.append(made.step(dict.fromkeys(made.agents, action))[0]["epuck_0"])
    return np.array(seen)


def test_what_supersuit_rescales_by_bounds_still_differs():
    long = {**FEW, "max_cycles": 400, "task.area_distance": 0.7}
    bare, scaled = (
        observed(wrap(parallel_env("es1", **long)))
        for wrap in (lambda made: made, WRAPPERS["normalize_obs"])
    )
    moving = bare.std(axis=0) > 0.0
    assert moving.sum() > 15
    ratio = scaled[:, moving].std(axis=0) / bare[:, moving].std(axis=0)
    assert ratio.min() > 0.9
