"""SB3 trains on the robots of several worlds, reproducibly, and bootstraps time-outs."""

import numpy as np
import pytest
from gymnasium.spaces import Discrete
from numpy.testing import assert_array_equal
from stable_baselines3.common.vec_env import VecFrameStack, VecMonitor, VecNormalize

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed
from swarm_forage_env import parallel_env
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.random_streams import drawn_seed
from training.vec_env import SwarmVecEnv

FAST = {"physics": "kinematic", "task.n_robots": 4}


def make(**options):
    return SwarmVecEnv("es1", n_worlds=2, **FAST, **options)


def some(env, seed=0):
    """Actions of all rows, within the space."""
    rng, space = np.random.default_rng(seed), env.action_space
    if isinstance(space, Discrete):
        return rng.integers(space.n, size=env.num_envs)
    return rng.uniform(space.low, space.high, (env.num_envs, *space.shape)).astype(np.float32)


@pytest.mark.parametrize(
    "options",
    [
        {"decision_period": 5, "shaping": 1.0},
        {"normalise": False, "action": "wheels", "learn": "both"},
        {"discrete": True, "decision_period": 2, "stack": 2},
        {"learners": [0, 3], "learn": "weighting", "reward": "team"},
        {"learn": "everything", "observation": ["layer", "previous_action", "robot_id"]},
    ],
)
def test_a_row_is_a_robot_and_goes_through_what_its_world_goes_through_alone(options):
    env = SwarmVecEnv("es1", n_worlds=2, seed=3, **options)
    n = env.num_envs // 2
    alone = parallel_env("es1", **options)
    observed = env.reset()
    first, _ = alone.reset(seed=drawn_seed(np.random.default_rng(4)))
    assert_array_equal(observed[n:], np.stack(list(first.values())))
    for step in range(40):
        actions = some(env, step)
        observed, rewards, done, infos = env.step(actions)
        first, reward, _, _, told = alone.step(dict(zip(alone.agents, actions[n:], strict=True)))
        assert_array_equal(observed[n:], np.stack(list(first.values())))
        assert_array_equal(rewards[n:], np.float32(list(reward.values())))
        assert not done.any()
        for own, others in zip(infos[n:], told.values(), strict=True):
            assert own == {"unshaped_reward": others["unshaped_reward"]}


@pytest.mark.parametrize("learn", ["motion", "everything"])
def test_a_time_out_is_marked_and_the_next_episode_starts_from_other_seeds(learn):
    env = make(max_cycles=3, learn=learn, randomise={"radio.max_range": (0.1, 0.2)})
    env.set_options({"task.area_distance": 1.2})
    with pytest.raises(UnknownNameError, match="did you mean"):
        env.set_options({"task.area_distanse": 1.1})
    start = env.reset()
    for _ in range(2):
        assert env.scenario.task.area_distance == 1.2
        _, _, done, infos = env.step(some(env))
        assert not done.any()
        assert [set(info) for info in infos] == [{"unshaped_reward"}] * 8
    drawn = np.repeat(env.env.episodes.drawn["radio.max_range"], 4)
    observed, _, done, infos = env.step(some(env))
    assert done.all()
    assert all(info["TimeLimit.truncated"] for info in infos)
    assert [info["round_trips"] for info in infos] == [0] * 8
    assert [info["radio.max_range"] for info in infos] == drawn.tolist()
    last = np.stack([info["terminal_observation"] for info in infos])
    assert last.shape == observed.shape
    assert (last != observed).any()
    assert (observed != start).any()
    assert env.scenario.task.area_distance == 1.5
    assert not env.step(some(env))[2].any()


def test_a_seed_fixes_the_sequence_of_episodes():
    def episodes(seed):
        env = make(max_cycles=2)
        env.seed(seed)
        return [env.reset(), *(env.step(some(env))[0] for _ in range(5))]

    assert_array_equal(episodes(1), episodes(1))
    assert_array_equal(episodes(1), episodes([1, 2]))
    assert (episodes(1)[3] != episodes(2)[3]).any()
    env = make(seed=[7, 7])
    observed = env.reset()
    assert_array_equal(observed[:4], observed[4:])
    with pytest.raises(ConfigError, match="must be 2 seeds, one for each world"):
        env.seed([1, 2, 3])


def test_what_sb3_wraps_around_environments_goes_around_these():
    env = VecFrameStack(VecNormalize(VecMonitor(make(max_cycles=3, shaping=1.0))), 2)
    observed = env.reset()
    n = len(env.get_attr("observation_layout")[0])
    assert observed.shape == (8, 2 * n)
    for _ in range(3):
        observed, _, done, infos = env.step(some(env))
    assert done.all()
    assert [info["episode"]["l"] for info in infos] == [3] * 8
    assert all(info["terminal_observation"].shape == (2 * n,) for info in infos)
    assert_array_equal(observed[:, :n], 0.0)


def test_frames_are_those_of_the_worlds():
    pytest.importorskip("pygame")
    env = make(render_mode="rgb_array", decision_period=5)
    env.reset()
    images = env.get_images()
    assert len(images) == env.num_envs
    assert_array_equal(images[0], env.render())
    assert (images[0] != images[4]).any()
    with pytest.raises(ConfigError, match="render_mode="):
        make().render()


def test_an_action_out_of_bounds_is_refused_with_its_robot_and_slot():
    env, other = make(), make()
    assert_array_equal(env.reset(), other.reset())
    actions = some(env)
    actions[5, 1] = 1.5
    with pytest.raises(ConfigError, match=r"action of epuck_1 of world 1: drive\.turn="):
        env.step(actions)
    assert_array_equal(env.step(some(env))[0], other.step(some(other))[0])


def test_a_step_without_an_action_is_refused():
    with pytest.raises(ConfigError, match="step_async"):
        make().step_wait()


def test_attributes_are_those_of_all_robots_and_cannot_be_set():
    env = make(decision_period=5)
    assert env.get_attr("max_cycles", [0, 1]) == [3600, 3600]
    assert env.get_attr("max_episode_steps", 3) == [3600]
    assert env.get_attr("render_mode") == [None] * 8
    with pytest.raises(ConfigError, match=r"set_attr\('max_cycles'\).*max_cycles=5"):
        env.set_attr("max_cycles", 5)
    assert env.max_cycles == 3600
    assert env.env_method("seed", 4, indices=[2]) == [[4] * 4 + [5] * 4]
    assert env.env_is_wrapped(VecMonitor) == [False] * 8
    assert [type(each).__name__ for each in env.np_random] == ["Generator"] * 2


@pytest.mark.parametrize(("period", "rate"), [(1, 10), (3, 3), (10, 1), (50, 1)])
def test_a_film_shows_as_many_decisions_as_pass_in_a_second_and_one_at_least(period, rate):
    assert make(decision_period=period).metadata["render_fps"] == rate
