"""The running policy of another trainer: which robots it takes over."""

from types import SimpleNamespace

import numpy as np
import pytest

from swarm_forage_env.interface import CORRECT, KEEP, REPLACE, RULE
from training.running_policy import RunningPolicy


@pytest.mark.parametrize(("residual", "mode"), [(False, REPLACE), (True, CORRECT)])
def test_a_policy_takes_over_its_robots_that_no_learner_has(residual, mode):
    action = np.zeros((1, 5), [("motion", np.int64), ("weighting", np.int64)])
    action["motion"] = [[KEEP, RULE, REPLACE, CORRECT, KEEP]]
    action["weighting"] = [[RULE, REPLACE, KEEP, KEEP, RULE]]
    form = SimpleNamespace(
        policy=SimpleNamespace(replaces=("weighting", "motion")),
        config=SimpleNamespace(residual=residual),
    )
    policy = SimpleNamespace(
        _world=SimpleNamespace(robots={"action": action}), _form=form, _robots=np.arange(4)
    )
    own = RunningPolicy._take_over(policy)
    assert own["motion"].tolist() == [[True, True, False, False, False]]
    assert own["weighting"].tolist() == [[True, False, True, True, False]]
    assert action["motion"].tolist() == [[mode, mode, REPLACE, CORRECT, KEEP]]
    assert action["weighting"].tolist() == [[REPLACE, REPLACE, REPLACE, REPLACE, RULE]]


def policy_at(ticks):
    """A running policy of robots 0 and 1 of three, in worlds at these ticks; what is noted."""
    n, noted = len(ticks), SimpleNamespace(asked=[], acted=[], begun=[], seen=None)
    policy = RunningPolicy.__new__(RunningPolicy)
    policy._world = SimpleNamespace(worlds={"ticks": np.array(ticks)}, n_worlds=n)
    policy._inner = SimpleNamespace(consult=lambda: noted.acted.append("rules"))
    policy._own, policy._robots = {}, np.arange(2)
    policy._held = np.full((n, 3, 2), 7.0, np.float32)

    def observe(world, inner, share_left, held):
        noted.seen, noted.share_left = held.copy(), share_left()
        return np.arange(n * 3 * 4, dtype=np.float32).reshape(n, 3, 4)

    policy._form = SimpleNamespace(config=SimpleNamespace(period=5), max_cycles=8, observe=observe)
    policy._frames = SimpleNamespace(
        add=lambda seen, due: noted.asked.append(due.tolist()),
        begin=lambda seen, worlds: noted.begun.append(worlds.tolist()) or seen,
    )
    policy._steer = lambda seen: seen[:, :2] + 100.0
    policy._act = lambda own: noted.acted.append("policy")
    return policy, noted


def test_a_policy_is_asked_where_a_decision_is_due_and_begins_from_nothing():
    policy, noted = policy_at([0, 3, 5, 60])
    policy.consult()
    assert noted.asked == [[0, 2, 3]]
    assert noted.begun == [[0]]
    assert noted.acted == ["policy", "rules"]
    # What was done before the episode began is nothing: the other worlds go on.
    assert noted.seen[:, 0, 0].tolist() == [0.0, 7.0, 7.0, 7.0]
    assert noted.share_left.tolist() == [1.0, 1.0, 7 / 8, 0.0]  # of eight decisions
    assert policy._held[0].tolist() == [[100.0, 101.0], [104.0, 105.0], [0.0, 0.0]]
    assert policy._held[1].tolist() == [[7.0, 7.0]] * 3
    assert policy._held[2, 0].tolist() == [124.0, 125.0]


def test_where_no_decision_is_due_an_action_is_held():
    policy, noted = policy_at([1, 4])
    policy.consult()
    assert noted.asked == []
    assert noted.acted == ["rules"]
    assert (policy._held == 7.0).all()


@pytest.mark.parametrize("learns", [True, False])
def test_the_actions_of_learners_are_left_as_they_were(learns):
    action = np.zeros((1, 3), [("wheels", np.float64, 2), ("weight", np.float64)])
    action["wheels"], action["weight"] = 1.0, 2.0

    def act(world, minds, robots, held):
        action["wheels"][:, robots] = held
        action["weight"][:, robots] = 5.0

    form = SimpleNamespace(act=act, task=SimpleNamespace(commanded="wheels"))
    policy = SimpleNamespace(
        _world=SimpleNamespace(robots={"action": action}), minds=None, _form=form,
        _robots=np.arange(2), _held=np.full((1, 3, 2), 9.0, np.float32),
    )  # fmt: skip
    own = np.array([[True, not learns, False]])
    RunningPolicy._act(policy, {"motion": own, "weighting": own})
    second = (1.0, 2.0) if learns else (9.0, 5.0)
    assert action["wheels"][0, :, 0].tolist() == [9.0, second[0], 1.0]
    assert action["weight"][0].tolist() == [5.0, second[1], 2.0]
