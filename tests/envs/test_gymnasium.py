"""Gymnasium's single environments: one learner among team-mates, all in one Box, all in a Tuple."""

from itertools import product

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Discrete
from gymnasium.utils.env_checker import check_env
from numpy.testing import assert_array_equal

from swarm_forage_env import ArrayEnv, ConfigError, UnknownNameError
from swarm_forage_env.envs.registration import NAMES
from swarm_forage_env.registry import SCENARIOS
from tests.commands import parallel_env
from tests.scripts import run_python

SINGLE, JOINT, TUPLE = (f"Commands/ES1{kind}-v0" for kind in ("", "-Joint", "-Tuple"))
FEW = {"task.n_robots": 3}


def test_every_scenario_has_its_ids():
    assert set(NAMES) == set(SCENARIOS)
    kinds = "", "-Joint", "-Tuple", "-Shared"
    names = product(NAMES.values(), kinds, (1, 2))
    ids = {f"SwarmForage/{name}{kind}-v{version}" for name, kind, version in names}
    assert {each for each in gym.registry if each.startswith("SwarmForage/")} == ids
    for scenario, name in NAMES.items():
        assert gym.spec(f"SwarmForage/{name}-Joint-v2").kwargs == {"scenario": scenario}


@pytest.mark.parametrize("kind", ["", "-Joint"])
@pytest.mark.parametrize("name", NAMES.values())
def test_gymnasium_accepts_the_single_learner_and_the_joint_env(name, kind):
    check_env(gym.make(f"SwarmForage/{name}{kind}-v2").unwrapped)


@pytest.mark.parametrize("name", ["ES1", "Waypoints-05"])
def test_gymnasium_accepts_the_tuple_env_but_for_its_list_of_rewards(name):
    env = gym.make(f"SwarmForage/{name}-Tuple-v2")
    with pytest.warns(UserWarning, match="reward returned by `step\\(\\)` must be a float") as log:
        check_env(env.unwrapped)
    assert len(log) == 1


@pytest.mark.parametrize("learn", ["weighting", "both", "everything"])
def test_gymnasium_accepts_every_layer(learn):
    check_env(gym.make("SwarmForage/ES1-Joint-v2", learn=learn).unwrapped)


def test_an_id_brings_its_module_and_the_import_brings_nothing_heavy():
    code = (
        "import sys, swarm_forage_env\n"
        "heavy = {'numba', 'pydantic', 'pymunk', 'baselines'} & set(sys.modules)\n"
        "import gymnasium, baselines.controllers\n"
        "env = gymnasium.make('swarm_forage_env:SwarmForage/ES1-v2', learn='weighting')\n"
        "print(sorted(heavy), env.unwrapped.action_layout.names)"
    )
    assert run_python("-c", code) == "[] ('g.nest', 'g.prey')"


@pytest.mark.parametrize("reward", ["own", "team"])
def test_the_joint_env_is_the_parallel_env_in_one_box(reward, busy):
    options = {"reward": reward, "shaping": 0.5, "max_cycles": 300}
    env, parallel = gym.make(JOINT, scenario=busy, **options), parallel_env(busy, **options)
    rng = np.random.default_rng(0)
    for seed in (4, None, None):
        seen, _ = env.reset(seed=seed)
        observations, _ = parallel.reset(seed=seed)
        assert_array_equal(seen, np.concatenate(list(observations.values())))
        for cycle in range(300):
            action = rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)
            seen, rewarded, terminated, truncated, info = env.step(action)
            rows = dict(zip(parallel.agents, action.reshape(10, 2), strict=True))
            observations, rewards, _, _, infos = parallel.step(rows)
            assert_array_equal(seen, np.concatenate(list(observations.values())))
            each = list(rewards.values())
            assert rewarded == (np.sum(each) if reward == "own" else each[0])
            assert not terminated
            assert truncated == (cycle == 299)
        by_robot = list(infos.values())
        assert info["messages"] == sum(each["messages"] for each in by_robot)
        assert info["on_path"] == np.mean([each["on_path"] for each in by_robot])
        assert info.keys() == by_robot[0].keys()


def test_as_many_learners_act_under_any_reward(busy):
    acts = []
    for reward in ("own", "team"):
        options = {"learn": "weighting", "step_on": "exchange", "reward": reward}
        env = gym.make("SwarmForage/ES1-Joint-v2", scenario=busy, **options)
        env.reset(seed=0)
        acts.append([env.step(np.zeros(20, np.float32))[4]["acts"] for _ in range(5)])
    assert acts[0] == acts[1] != [0.0] * 5


def test_the_tuple_env_has_the_form_of_level_based_foraging():
    env = gym.make(TUPLE, **FEW)
    assert env.unwrapped.n_agents == 3
    assert list(env.action_space) == [Discrete(9)] * 3
    observations, info = env.reset(seed=0)
    assert observations in env.observation_space
    assert isinstance(observations, tuple)
    observations, rewards, terminated, truncated, info = env.step([0, 4, 8])
    assert [each[-2:].tolist() for each in observations] == [[-1, -1], [0, 0], [1, 1]]
    assert rewards == [0.0, 0.0, 0.0]
    assert (terminated, truncated) == (False, False)
    assert set(map(type, info.values())) == {float}


def test_the_tuple_env_with_boxes_is_the_joint_env():
    boxes, joint = gym.make(TUPLE, discrete=False, **FEW), gym.make(JOINT, **FEW)
    assert list(boxes.action_space) == [Box(-1, 1, (2,))] * 3
    rng = np.random.default_rng(0)
    seen, all_seen = boxes.reset(seed=5)[0], joint.reset(seed=5)[0]
    for _ in range(50):
        assert_array_equal(np.concatenate(seen), all_seen)
        action = rng.uniform(-1, 1, (3, 2)).astype(np.float32)
        seen, all_seen = boxes.step(tuple(action))[0], joint.step(action.ravel())[0]


def test_one_robot_learns_where_one_is_promised():
    with pytest.raises(ConfigError, match="learners=2: one robot learns in this environment; name"):
        gym.make(SINGLE, learners=2)


@pytest.mark.parametrize(("most", "cycles"), [(3, 5), (5, 3), (None, 3)])
def test_the_shorter_of_time_limit_and_max_cycles_ends_an_episode(most, cycles):
    env = gym.make(SINGLE, max_episode_steps=most, max_cycles=cycles)
    assert ("TimeLimit" in str(env)) == (most is not None)
    for _ in range(2):
        env.reset()
        ends = [env.step(np.zeros(2, np.float32))[3] for _ in range(3)]
        assert ends == [False, False, True]


@pytest.mark.parametrize(
    ("made", "action", "message"),
    [
        (SINGLE, [0.0], r"of shape \(1,\): must be \(2,\); for each .*, wheels.left, wheels.right"),
        (JOINT, [0.0] * 5 + [-2.0], "epuck_2: wheels.right=-2.0: must be from -1 to 1"),
        (JOINT, np.zeros((3, 2)), r"shape \(3, 2\): must be \(6,\)"),
        (TUPLE, (0, 4), r"shape \(2,\): must be \(3,\); for each .*, a whole number from 0 to 8"),
        (TUPLE, (0, 4, 9), r"epuck_2: .*9.*: must be a whole number from 0 to 8"),
        (TUPLE, [True] * 3, r"epuck_0: .*: must be a whole number from 0 to 8"),
    ],
)
def test_a_bad_action_is_refused_and_changes_nothing(made, action, message):
    env, twin = gym.make(made, **FEW).unwrapped, gym.make(made, **FEW).unwrapped
    env.reset(seed=2)
    twin.reset(seed=2)
    with pytest.raises(ConfigError, match=message):
        env.step(action)
    env.action_space.seed(0)
    good = env.action_space.sample()
    (seen, *rest), (expected, *others) = env.step(good), twin.step(good)
    assert_array_equal(seen, expected)
    assert rest == others


def test_nothing_is_drawn_without_a_mode():
    swarm = gym.make(JOINT).unwrapped
    with pytest.raises(ResetNeeded, match="call reset"):
        swarm.render()
    swarm.reset(seed=0)
    with pytest.raises(ConfigError, match="set render_mode='human', 'rgb_array' or 'ansi'"):
        swarm.render()
    with pytest.raises(ConfigError, match=r"^render_mode='ansi': this interface .* parallel_env"):
        ArrayEnv("es1", render_mode="ansi")


def test_a_refused_reset_draws_no_seed():
    one, other = (gym.make(JOINT, learn="everything", **FEW).unwrapped for _ in range(2))
    one.reset(seed=1)
    other.reset(seed=1)
    with pytest.raises(UnknownNameError, match="named 'colour'"):
        one.reset(options={"colour": "red"})
    with pytest.raises(ConfigError, match="those of controller 'policy' cannot be falsified"):
        one.reset(options={"faults.liar.share": 0.4})
    assert_array_equal(one.reset()[0], other.reset()[0])
