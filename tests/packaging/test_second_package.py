"""A second package adds weighting rules, a controller and an environment id, with no edit here."""

import os
from pathlib import Path

import pytest

from tests.processes import run

SECOND = Path(__file__).parent / "second"


def told(code):
    """What a script prints that has the second package on its path, as an installation has."""
    paths = [str(SECOND), str(SECOND.parents[2]), os.environ.get("PYTHONPATH", "")]
    variables = {"PYTHONPATH": os.pathsep.join(paths), "SWARM_CHECK_SHAPES": "1"}
    script = "import baselines.controllers\n" + code
    return run("-W", "error", "-c", script, variables=variables)[0].strip()


def test_its_rule_is_found_by_name_and_weighs_in_an_environment():
    code = """
from swarm_forage_env import parallel_env
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.rows import RowWeighting

env = parallel_env(learn="motion", controller="cautious:trust=0.25")
loop = env.array_env.loop
layer = loop.controller.weighting
exchange = loop.exchange
exchange.is_valid = exchange.own_known = exchange.heard_known = 1.0
exchange.own_p, exchange.heard_p = 3.0, 1.0
weights = RowWeighting(layer)(exchange)
print(WEIGHTING_RULES["cautious"].__module__, layer.gain.__module__, set(weights.flat))
"""
    assert told(code) == "cautious_swarm cautious_swarm {np.float32(0.1875)}"


def test_its_rule_in_numpy_runs_in_a_composition_and_does_what_its_compiled_rule_does():
    code = """
import numpy as np
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop

scenario = find_scenario("es1", {"cruise_speed": 0.12, "area_distance": 0.7})
loops = [Loop(scenario, find_controller(f"social_odometry+{rule}+subsumption"), [0, 1])
         for rule in ("cautious", "cautious_arrays")]
weights = []
for _ in range(600):
    for loop in loops:
        loop.step()
    assert np.array_equal(*(loop.world.robots["pose"] for loop in loops))
    exchange = loops[1].controller.minds["estimator"]["exchange"]
    weights.extend(exchange["weight"][exchange["is_valid"] > 0].flat)
assert np.array_equal(*(loop.controller.minds["estimator"]["belief"] for loop in loops))
print(0.0 < max(weights) <= 0.5)
"""
    assert told(code) == "True"


@pytest.mark.parametrize("make", ["make", "make_vec"])
def test_its_id_makes_our_environment_with_its_controller(make):
    code = f"""
import gymnasium as gym

env = gym.{make}("cautious_swarm:CautiousSwarm/ES1-v0", learn="motion").unwrapped
env.reset(seed=0)
print(type(env).__name__, env.world.n_robots, env.spec.id)
print(env.array_env.loop.controller.weighting.gain.__module__)
for _ in range(5):
    env.step(env.action_space.sample())
"""
    name = {"make": "LearnerEnv", "make_vec": "LearnerVectorEnv"}[make]
    assert told(code).split() == [name, "5", "CautiousSwarm/ES1-v0", "cautious_swarm"]
