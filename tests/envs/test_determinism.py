"""One seed, one episode: in one process, in two, and after any other episode."""

import os
import subprocess
import sys
from hashlib import sha256

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.foraging.policies import LEARNABLE
from tests.commands import parallel_env

STEPS = 500


def digest(env, seed, steps=STEPS):
    """A hash of all that 500 random steps give: observations, rewards, ends, infos and state."""
    text = sha256()

    def take(observations, *rest):
        for agent in observations:
            text.update(observations[agent].tobytes())
        text.update(repr(rest).encode() + env.state().tobytes())

    take(*env.reset(seed=seed))
    rng = np.random.default_rng(seed)
    box = env.action_space(env.agents[0])
    for _ in range(steps):
        actions = {a: rng.uniform(box.low, box.high).astype(np.float32) for a in env.agents}
        take(*env.step(actions))
    return text.hexdigest()


def digest_elsewhere(learn, hash_seed):
    """The same in another process, whose sets and dictionaries are in another order."""
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import baselines.controllers\n"
        "from tests.commands import parallel_env\n"
        "from test_determinism import digest\n"
        "print(digest(parallel_env(learn=sys.argv[2]), 11))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, os.path.dirname(__file__), learn],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return run.stdout.strip()


@pytest.mark.parametrize("learn", list(LEARNABLE))
def test_one_seed_one_episode(learn):
    env = parallel_env(learn=learn)
    first = digest(env, 11)
    assert digest(env, 12) != first
    assert digest(env, 11) == first
    assert digest(parallel_env(learn=learn), 11) == first


@pytest.mark.parametrize("learn", ["both", "everything"])
def test_one_seed_one_episode_in_every_process(learn):
    here = digest(parallel_env(learn=learn), 11)
    assert {digest_elsewhere(learn, hash_seed) for hash_seed in "12"} == {here}


def first_states(env, n):
    states = []
    for _ in range(n):
        env.reset()
        states.append(env.state())
    return np.array(states)


def test_a_seed_fixes_the_episodes_that_follow_without_one():
    one, two = parallel_env(), parallel_env()
    one.reset(seed=4)
    seeded = one.state()
    two.reset(seed=4)
    follow = first_states(one, 3)
    assert_array_equal(follow, first_states(two, 3))
    assert len(np.unique(np.vstack([seeded, follow]), axis=0)) == 4


def test_without_any_seed_every_environment_is_another():
    assert (first_states(parallel_env(), 1) != first_states(parallel_env(), 1)).any()
