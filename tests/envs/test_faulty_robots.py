"""Environments whose robots may be faulty: the state says which are, and no observation does."""

import numpy as np
import pytest

from swarm_forage_env import ArrayEnv
from swarm_forage_env.epuck.fault_record import KINDS

FAULTY = {"faults.dead.robots": (1,), "faults.liar.robots": (2, 3)}


def steps(env, n=3):
    env.reset(seed=1)
    shape = (env.n_worlds, len(env.learners), *env.action_shape)
    for _ in range(n):
        found = env.step(np.zeros(shape, np.float32))
    return found


def test_the_state_says_which_faults_are_in_effect():
    plain, env = (
        ArrayEnv("es1", physics="kinematic", normalise=False, **more) for more in ({}, FAULTY)
    )
    assert len(env.state_layout) == len(plain.state_layout) + 10 * len(KINDS)
    steps(env)
    names = [feature.name for feature in env.state_layout]
    state = dict(zip(names, env.state()[0].tolist(), strict=True))
    found = {name for name, value in state.items() if ".fault." in name and value}
    assert found == {"epuck_1.fault.dead", "epuck_2.fault.liar", "epuck_3.fault.liar"}
    assert env.state_space.contains(env.state()[0])


@pytest.mark.parametrize("learn", ["weighting", "both"])
def test_a_robot_that_will_die_observes_what_a_sound_one_does(learn):
    soon = {"faults.dead.robots": (1,), "faults.dead.at": 3.0, "faults.liar.share": 0.2}
    plain, doomed = (
        ArrayEnv("es1", learn=learn, physics="kinematic", **more) for more in ({}, soon)
    )
    np.testing.assert_array_equal(steps(plain)[0], steps(doomed)[0])
    assert doomed.observation_layout == plain.observation_layout


def test_a_share_of_liars_may_be_drawn_for_every_episode():
    env = ArrayEnv(
        "es1", n_worlds=3, physics="kinematic", randomise={"faults.liar.share": (0.0, 0.5)}
    )
    n_liars = []
    for seed in range(5):
        _, infos = env.reset(seed=3 * seed)
        kinds = env.world.faults["kinds"]
        n_liars += kinds.any(axis=2).sum(axis=1).tolist()
        drawn = infos["faults.liar.share"]
        np.testing.assert_array_equal(kinds.any(axis=2).sum(axis=1), np.floor(10 * drawn + 0.5))
        assert env.state_space.contains(env.state()[0])
    assert len(set(n_liars)) > 2
