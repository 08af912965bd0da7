"""Copies of every environment go on as the original, and seeds start a sequence of episodes."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest

import swarm_forage_env  # noqa: F401 enters the ids
from swarm_forage_env import swarm_forage_v2
from training.vec_env import SwarmVecEnv

ENGINES = "kinematic", "rigid"
COPIES = {"deepcopy": copy.deepcopy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}
STEPS = 12
SHORT = {"max_cycles": 9, "learn": "motion", "decision_period": 20}
"""Episodes that end, and start anew, within the steps that are compared."""


def dict_step(env, rng):
    actions = {name: rng.uniform(-1, 1, env.action_space(name).shape) for name in env.agents}
    found = [] if not actions else [each for part in env.step(actions) for each in part.values()]
    if not env.agents:
        found += list(env.reset()[0].values())
    return found


def single_step(env, rng):
    found = list(env.step(rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)))
    return [*found, env.reset()[0]] if found[3] else found


def vector_step(env, rng):
    return list(env.step(rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)))


def sb3_step(env, rng):
    return list(env.step(rng.uniform(-1, 1, (env.num_envs, *env.action_space.shape))))


MADE = {
    "pettingzoo": (
        lambda **given: swarm_forage_v2.parallel_env("es1", **given),
        lambda env: env.reset(seed=3),
        dict_step,
    ),
    "gymnasium": (
        lambda **given: gymnasium.make("SwarmForage/ES1-v2", **given),
        lambda env: env.reset(seed=3),
        single_step,
    ),
    "vector": (
        lambda **given: gymnasium.make_vec("SwarmForage/ES1-v2", num_envs=2, **given),
        lambda env: env.reset(seed=3),
        vector_step,
    ),
    "sb3": (
        lambda **given: SwarmVecEnv("es1", n_worlds=2, **given),
        lambda env: (env.seed(3), env.reset()),
        sb3_step,
    ),
}


def seen(env, step, steps):
    """Everything that some random steps give back, as bytes."""
    rng = np.random.default_rng(5)
    return [pickle.dumps(each) for _ in range(steps) for each in step(env, rng)]


@pytest.mark.parametrize("api", MADE)
def test_a_seed_starts_the_sequence_of_the_episodes_that_follow_it(api):
    make, reset, step = MADE[api]
    env = make(physics="kinematic", **SHORT)
    runs = []
    for _ in range(2):
        reset(env)
        env.reset()  # without a seed: the next of the sequence
        runs.append(seen(env, step, STEPS))
    assert runs[0] == runs[1]


@pytest.mark.parametrize("kind", COPIES)
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("api", MADE)
def test_a_copy_goes_on_as_the_original(api, engine, kind):
    make, reset, step = MADE[api]
    env = make(physics=engine, **SHORT)
    reset(env)
    seen(env, step, 4)
    other = COPIES[kind](env)
    theirs = seen(other, step, STEPS)
    assert len(set(theirs)) > STEPS, "the observations of a copy change"
    assert seen(env, step, STEPS) == theirs


@pytest.mark.parametrize("kind", COPIES)
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("api", MADE)
def test_a_copy_of_one_that_was_not_reset_starts_as_the_original(api, engine, kind):
    make, reset, step = MADE[api]
    env = make(physics=engine, **SHORT)
    other = COPIES[kind](env)
    for each in (other, env):
        reset(each)
    assert seen(other, step, STEPS) == seen(env, step, STEPS)
