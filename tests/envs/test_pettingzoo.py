"""PettingZoo's own tests, for every layer that can be learned."""

import pytest
from pettingzoo.test import (
    api_test,
    parallel_api_test,
    parallel_seed_test,
    seed_test,
    state_test,
)

from swarm_forage_env import env, parallel_env, raw_env
from swarm_forage_env.foraging.policies import LEARNABLE

every_layer = pytest.mark.parametrize("learn", list(LEARNABLE))
few = {"task.n_robots": 4}


@every_layer
def test_pettingzoo_accepts_agents_in_turn(learn):
    api_test(env(learn=learn, max_cycles=40, **few), num_cycles=100)


@every_layer
def test_pettingzoo_accepts_agents_in_parallel(learn):
    parallel_api_test(parallel_env(learn=learn, **few), num_cycles=100)


@every_layer
def test_pettingzoo_finds_one_seed_one_episode_in_turn(learn):
    seed_test(lambda: env(learn=learn, **few), num_cycles=50)


@every_layer
def test_pettingzoo_finds_one_seed_one_episode_in_parallel(learn):
    parallel_seed_test(lambda: parallel_env(learn=learn, **few), num_cycles=50)


@every_layer
def test_pettingzoo_accepts_the_state(learn):
    options = {"learn": learn, "max_cycles": 30, **few}
    state_test(env(**options), parallel_env(**options), num_cycles=40)


def test_agents_in_turn_are_as_bare_as_in_parallel():
    turns = raw_env(learn="weighting", max_cycles=3, **few)
    turns.reset(seed=1)
    assert turns.possible_agents == ["epuck_0", "epuck_1", "epuck_2", "epuck_3"]
    assert turns.metadata["name"] == "swarm_forage_v2"
    assert turns.unwrapped.render_mode is None


def test_all_robots_are_truncated_together_and_none_dies(sampler):
    parallel = parallel_env(max_cycles=5, **few)
    parallel.reset(seed=0)
    act = sampler(parallel, 0)
    for cycle in range(5):
        _, _, terminations, truncations, _ = parallel.step(act())
        assert not any(terminations.values())
        assert set(truncations.values()) == {cycle == 4}
    assert parallel.agents == []


def test_an_episode_lasts_the_scenario_time():
    assert parallel_env("es1").max_cycles == 1_800
    assert parallel_env("es1", decision_period=7).max_cycles == 18_000 // 7
    assert parallel_env("es1", max_cycles=9).max_cycles == 9
