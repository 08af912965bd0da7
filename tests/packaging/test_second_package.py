"""A second package adds a weighting rule, a controller and an environment id, with no edit here."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SECOND = Path(__file__).parent / "second"


def told(code):
    """What a script prints that has the second package on its path, as an installation has."""
    paths = [str(SECOND), str(SECOND.parents[2]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    command = [sys.executable, "-W", "error", "-c", "import baselines.recipes\n" + code]
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


def test_its_rule_is_found_by_name_and_weighs_in_an_environment():
    code = """
from dataclasses import replace
import numpy as np
from swarm_forage_env import parallel_env
from baselines.weighting import WEIGHTING_RULES

env = parallel_env(learn="motion", controller="cautious:trust=0.25")
inside = env._batch.cut._loop.controller
encounter = replace(inside.estimator.encounter, own_p=np.full((10, 2), 3, np.float32),
                    heard_p=np.full((10, 2), 1, np.float32))
print(type(inside.weighting) is WEIGHTING_RULES["cautious"], set(inside.weighting(encounter).flat))
"""
    assert told(code) == "True {np.float32(0.1875)}"


def test_its_controller_takes_part_in_an_evaluation():
    code = """
from baselines.evaluation.episode import run_episodes
from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller

scenario = find_scenario("es1", {"duration": 60.0})
(episode,) = run_episodes(scenario, find_controller("cautious"), seeds=[0])
print(episode.controller)
"""
    assert told(code) == "cautious"


@pytest.mark.parametrize("make", ["make", "make_vec"])
def test_its_id_makes_our_environment_with_its_controller(make):
    code = f"""
import gymnasium as gym

env = gym.{make}("cautious_swarm:CautiousSwarm/ES1-v0", learn="motion").unwrapped
env.reset(seed=0)
print(type(env).__name__, env.world.n_robots, env.spec.id)
print(type(env._block.batch.cut._loop.controller.weighting).__name__)
for _ in range(5):
    env.step(env.action_space.sample())
"""
    name = {"make": "LearnerEnv", "make_vec": "LearnerVectorEnv"}[make]
    assert told(code).split() == [name, "5", "CautiousSwarm/ES1-v0", "Cautious"]
