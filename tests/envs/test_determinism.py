"""One seed, one episode in every process; without any, another."""

from hashlib import sha256

import numpy as np
import pytest

from tests.commands import parallel_env
from tests.scripts import run_python


def digest(env, seed):
    """A hash of all that 500 random steps give: observations, rewards, ends, infos and state."""
    text = sha256()

    def take(observations, *rest):
        for agent in observations:
            text.update(observations[agent].tobytes())
        text.update(repr(rest).encode() + env.state().tobytes())

    take(*env.reset(seed=seed))
    rng = np.random.default_rng(seed)
    box = env.action_space(env.agents[0])
    for _ in range(500):
        actions = {a: rng.uniform(box.low, box.high).astype(np.float32) for a in env.agents}
        take(*env.step(actions))
    return text.hexdigest()


@pytest.mark.parametrize("learn", ["both", "everything"])
def test_one_seed_one_episode_in_every_process(learn):
    """In another process sets and dictionaries are in another order."""
    code = (
        "import baselines.controllers\n"
        "from tests.envs.test_determinism import digest, parallel_env\n"
        f"print(digest(parallel_env(learn={learn!r}), 11))"
    )
    here = digest(parallel_env(learn=learn), 11)
    assert {run_python("-c", code, PYTHONHASHSEED=each) for each in "12"} == {here}


def test_without_any_seed_every_environment_is_another():
    one, other = parallel_env(), parallel_env()
    one.reset()
    other.reset()
    assert (one.state() != other.state()).any()
