"""Copies of every environment go on as the original, and seeds start a sequence of episodes."""

import copy
import pickle
from functools import partial

import gymnasium
import numpy as np
import pytest

import swarm_forage_env  # noqa: F401 enters the ids
from swarm_forage_env import swarm_forage_v2
from training.vec_env import SwarmVecEnv

COPIES = {"deepcopy": copy.deepcopy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}
STEPS = 12
SHORT = {"max_cycles": 9, "learn": "motion", "decision_period": 20}
"""Episodes that end, and start anew, within the steps that are compared."""


def dict_step(env, rng):
    actions = {name: rng.uniform(-1, 1, 2) for name in env.agents}
    found = [each for part in env.step(actions) for each in part.values()]
    return found if env.agents else [*found, *env.reset()[0].values()]


def single_step(env, rng):
    found = list(env.step(rng.uniform(-1, 1, 2).astype(np.float32)))
    return [*found, env.reset()[0]] if found[3] else found


def rows_step(env, rng):
    return list(env.step(rng.uniform(-1, 1, (env.num_envs, 2)).astype(np.float32)))


def seeded(env):
    env.reset(seed=3)


MADE = {
    "pettingzoo": (partial(swarm_forage_v2.parallel_env, "es1"), seeded, dict_step),
    "gymnasium": (partial(gymnasium.make, "SwarmForage/ES1-v2"), seeded, single_step),
    "vector": (partial(gymnasium.make_vec, "SwarmForage/ES1-v2", num_envs=2), seeded, rows_step),
    "sb3": (
        partial(SwarmVecEnv, "es1", n_worlds=2),
        lambda env: (env.seed(3), env.reset()),
        rows_step,
    ),
}


def seen(env, step, steps):
    """Everything that some random steps give back, as bytes."""
    rng = np.random.default_rng(5)
    return [pickle.dumps(each) for _ in range(steps) for each in step(env, rng)]


@pytest.mark.parametrize("kind", COPIES)
@pytest.mark.parametrize("api", MADE)
def test_a_copy_goes_on_as_the_original(api, kind):
    make, reset, step = MADE[api]
    env = make(**SHORT)
    reset(env)
    seen(env, step, 4)
    other = COPIES[kind](env)
    theirs = seen(other, step, STEPS)
    assert len(set(theirs)) > STEPS, "the observations of a copy change"
    assert seen(env, step, STEPS) == theirs


@pytest.mark.parametrize("kind", COPIES)
@pytest.mark.parametrize("api", MADE)
def test_a_copy_of_one_that_was_not_reset_starts_as_the_original(api, kind):
    make, reset, step = MADE[api]
    env = make(**SHORT)
    other = COPIES[kind](env)
    for each in (other, env):
        reset(each)
    assert seen(other, step, STEPS) == seen(env, step, STEPS)


def first_observations(env):
    """Observations of the first episode after a reset without a seed, as bytes."""
    found = env.reset()
    return pickle.dumps(found if isinstance(found, np.ndarray) else found[0])


@pytest.mark.parametrize("kind", COPIES)
@pytest.mark.parametrize("api", [name for name in MADE if name != "sb3"])
def test_copies_of_one_without_a_seed_play_other_episodes(api, kind):
    env = MADE[api][0](**SHORT)
    copies = [COPIES[kind](env), COPIES[kind](env)]
    copies += [COPIES[kind](copies[0]), MADE[api][0](**SHORT)]  # a copy of a copy; another one
    assert len({first_observations(each) for each in (env, *copies)}) == 5


@pytest.mark.parametrize("kind", COPIES)
def test_copies_of_one_that_was_seeded_and_not_reset_play_its_episodes(kind):
    env = SwarmVecEnv("es1", n_worlds=2, seed=3)
    assert first_observations(COPIES[kind](env)) == first_observations(env)


def test_a_copy_reads_no_scenario_file_again(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('base = "near"', encoding="utf-8")
    env = swarm_forage_v2.parallel_env(file)
    file.unlink()
    assert copy.deepcopy(env).scenario == env.scenario
