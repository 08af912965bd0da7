"""PettingZoo's own tests, its registry from version 1.27 on, and the module as it lays it out."""

import numpy as np
import pettingzoo
import pytest
from numpy.testing import assert_array_equal
from pettingzoo.test import (
    api_test,
    max_cycles_test,
    parallel_api_test,
    parallel_seed_test,
    seed_test,
    state_test,
)

from swarm_forage_env import env, parallel_env, swarm_forage_v1, swarm_forage_v2
from swarm_forage_env.envs.registration import NAMES, register_with_pettingzoo
from swarm_forage_env.foraging.policies import LEARNABLE


def made(kind, scenario="es1", **options):
    return pettingzoo.make(kind, f"swarm_forage/{scenario}-v2", **options)


@pytest.mark.parametrize("learn", LEARNABLE)
def test_pettingzoo_accepts_every_layer(learn):
    options = {"learn": learn, "task.n_robots": 4}
    api_test(env(max_cycles=40, **options), num_cycles=100)
    api_test(made("aec", max_cycles=4, discrete=True, **options), num_cycles=20)
    parallel_api_test(parallel_env(**options), num_cycles=100)
    seed_test(lambda: env(**options), num_cycles=50)
    parallel_seed_test(lambda: parallel_env(**options), num_cycles=50)
    short = {**options, "max_cycles": 30}
    state_test(env(**short), parallel_env(**short), num_cycles=40)


@pytest.mark.parametrize("scenario", NAMES)
def test_pettingzoo_accepts_every_id(scenario):
    parallel_api_test(made("parallel", scenario, max_cycles=20), num_cycles=30)


def test_an_episode_lasts_the_scenario_time():
    assert parallel_env("es1").max_cycles == 1_800
    assert parallel_env("es1", decision_period=7).max_cycles == 18_000 // 7


def test_every_scenario_is_in_both_registries():
    expected = {f"swarm_forage/{scenario}-v{v}" for scenario in NAMES for v in (1, 2)}
    for registry in (pettingzoo.aec_registry, pettingzoo.parallel_registry):
        assert {each for each in registry if each.startswith("swarm_forage/")} == expected


def test_an_id_is_its_environment_with_its_keywords(constant):
    options = {"learn": "weighting", "max_cycles": 3, "radio.max_range": 0.2}
    by_id, direct = made("parallel", "es2", **options), parallel_env("es2", **options)
    assert by_id.scenario == direct.scenario
    by_id.reset(seed=4)
    direct.reset(seed=4)
    for cycle in range(3):
        one, other = by_id.step(constant(by_id, 0.5, 0.5)), direct.step(constant(direct, 0.5, 0.5))
        assert_array_equal(np.stack(list(one[0].values())), np.stack(list(other[0].values())))
        assert one[1:] == other[1:]
        assert set(one[2].values()) == {False}, "nobody dies"
        assert set(one[3].values()) == {cycle == 2}
    assert by_id.agents == []


def test_the_module_is_laid_out_as_pettingzoos_are():
    for module in (swarm_forage_v1, swarm_forage_v2):
        max_cycles_test(module)
        assert module.raw_env().metadata["name"] == "swarm_forage_v2"


def test_a_pettingzoo_without_registry_is_let_be(monkeypatch):
    monkeypatch.delattr(pettingzoo, "register")
    before = dict(pettingzoo.parallel_registry)
    register_with_pettingzoo()
    assert pettingzoo.parallel_registry == before
