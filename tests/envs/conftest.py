"""What the tests of the environment share."""

import numpy as np
import pytest

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed


@pytest.fixture
def constant():
    """The same action for every agent of an environment."""

    def make(env, *values):
        action = np.array(values, np.float32)
        return dict.fromkeys(env.possible_agents, action)

    return make


@pytest.fixture
def sampler():
    """A function that draws an action for every agent of an environment, from one seed."""

    def make(env, seed):
        rng = np.random.default_rng(seed)
        box = env.action_space(env.possible_agents[0])
        return lambda: {
            agent: rng.uniform(box.low, box.high).astype(np.float32)
            for agent in env.possible_agents
        }

    return make
