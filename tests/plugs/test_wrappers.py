"""Wrappers of SuperSuit and Gymnasium that rescale, skip and tell the time go round ours."""

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
