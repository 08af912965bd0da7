"""PettingZoo's registry, from its version 1.27 on, and the module as PettingZoo lays them out."""

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
)

from swarm_forage_env import parallel_env, swarm_forage_v1, swarm_forage_v2
from swarm_forage_env.envs.registration import NAMES, register_with_pettingzoo

ids = pytest.mark.parametrize("scenario", NAMES)


def made(kind, scenario="es1", **options):
    return pettingzoo.make(kind, f"swarm_forage/{scenario}-v2", **options)


def test_every_scenario_is_in_both_registries():
    expected = {f"swarm_forage/{scenario}-v{v}" for scenario in NAMES for v in (1, 2)}
    for registry in (pettingzoo.aec_registry, pettingzoo.parallel_registry):
        assert {each for each in registry if each.startswith("swarm_forage/")} == expected


@ids
def test_pettingzoo_accepts_every_id_in_parallel(scenario):
    parallel_api_test(made("parallel", scenario, max_cycles=20), num_cycles=30)


@ids
def test_pettingzoo_accepts_every_id_in_turn(scenario):
    api_test(made("aec", scenario, max_cycles=2, **{"n_robots": 3}), num_cycles=20)


@pytest.mark.parametrize("scenario", ["es2", "real", "waypoints-05"])
def test_pettingzoo_finds_one_seed_one_episode(scenario):
    few = {"n_robots": 3, "max_cycles": 30}
    seed_test(lambda: made("aec", scenario, **few), num_cycles=40)
    parallel_seed_test(lambda: made("parallel", scenario, **few), num_cycles=40)


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
        assert set(one[3].values()) == {cycle == 2}


def test_the_module_is_laid_out_as_pettingzoos_are():
    for module in (swarm_forage_v1, swarm_forage_v2):
        max_cycles_test(module)
        assert module.raw_env().metadata["name"] == "swarm_forage_v2"


def test_a_pettingzoo_without_registry_is_let_be(monkeypatch):
    monkeypatch.delattr(pettingzoo, "register")
    before = dict(pettingzoo.parallel_registry)
    register_with_pettingzoo()
    assert pettingzoo.parallel_registry == before
