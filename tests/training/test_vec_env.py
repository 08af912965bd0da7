"""SB3 trains on the robots of several worlds, reproducibly, and bootstraps time-outs."""

import runpy
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed
from swarm_forage_env import parallel_env
from swarm_forage_env.errors import ConfigError, UnknownNameError
from training.vec_env import SwarmVecEnv

EXAMPLE = Path(__file__).parents[2] / "examples" / "sb3_ppo.py"
FAST = {"physics": "kinematic", "task.n_robots": 4}


def make(**options):
    return SwarmVecEnv("es1", n_worlds=2, **FAST, **options)


def zeros(env):
    return np.zeros((env.num_envs, *env.action_space.shape), np.float32)


def test_a_row_is_a_robot_and_goes_through_what_its_world_goes_through_alone():
    env = SwarmVecEnv("es1", n_worlds=2, seed=3, decision_period=5)
    observed = env.reset()
    seeds = np.random.default_rng(3).integers(2**63, size=2)
    alone = parallel_env("es1", decision_period=5)
    first, _ = alone.reset(seed=int(seeds[1]))
    assert_array_equal(observed[10:], np.stack(list(first.values())))
    action = np.full(2, 0.5, np.float32)
    for _ in range(50):
        observed, rewards, _, _ = env.step(np.tile(action, (20, 1)))
        first, reward, *_ = alone.step(dict.fromkeys(alone.agents, action))
        assert_array_equal(observed[10:], np.stack(list(first.values())))
        assert_array_equal(rewards[10:], np.float32(list(reward.values())))


def test_a_time_out_is_marked_and_the_next_episode_starts_from_other_seeds():
    env = make(max_cycles=3)
    start = env.reset()
    for _ in range(2):
        _, _, done, infos = env.step(zeros(env))
        assert not done.any()
        assert infos == [{}] * 8
    observed, _, done, infos = env.step(zeros(env))
    assert done.all()
    assert all(info["TimeLimit.truncated"] for info in infos)
    assert [info["round_trips"] for info in infos] == [0] * 8
    last = np.stack([info["terminal_observation"] for info in infos])
    assert last.shape == observed.shape
    assert (last != observed).any()
    assert (observed != start).any()


def test_a_seed_fixes_the_sequence_of_episodes():
    def episodes(seed):
        env = make(max_cycles=2)
        env.seed(seed)
        return [env.reset(), *(env.step(zeros(env))[0] for _ in range(5))]

    assert_array_equal(episodes(1), episodes(1))
    assert (episodes(1)[3] != episodes(2)[3]).any()


def test_two_seeded_ppo_runs_end_with_equal_parameters():
    def trained():
        env = make(learn="motion", decision_period=5, max_cycles=20)
        model = PPO("MlpPolicy", env, n_steps=16, batch_size=64, n_epochs=2, seed=0, device="cpu")
        return model.learn(2 * 16 * env.num_envs).policy.state_dict()

    first, second = trained(), trained()
    assert first.keys() == second.keys()
    assert all(torch.equal(first[name], second[name]) for name in first)


def test_sb3_bootstraps_what_the_time_limit_cuts_off():
    env = make(decision_period=5, max_cycles=8)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=64, n_epochs=1, seed=0, device="cpu")
    with torch.no_grad():
        model.policy.value_net.bias.fill_(10.0)
    model.learn(8 * env.num_envs)
    assert model.rollout_buffer.rewards[-1].min() > 5.0
    assert model.rollout_buffer.rewards[:-1].max() < 5.0


@pytest.mark.parametrize("value", [1.5, np.nan, -np.inf])
def test_an_action_out_of_bounds_is_refused_with_its_robot_and_slot(value):
    env = make()
    before = env.reset()
    actions = zeros(env)
    actions[5, 1] = value
    with pytest.raises(ConfigError, match=r"environment 5: wheels\.right="):
        env.step(actions)
    assert_array_equal(env.step(zeros(env))[0].shape, before.shape)


def test_actions_of_another_shape_are_refused():
    with pytest.raises(ConfigError, match=r"shape \(8, 3\): must be \(8, 2\)"):
        make().step(np.zeros((8, 3), np.float32))


def test_a_step_without_an_action_is_refused():
    with pytest.raises(ConfigError, match="step_async"):
        make().step_wait()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"n_worlds": 0}, ConfigError, "n_worlds=0"),
        ({"learn": "motoin"}, UnknownNameError, "motion"),
        ({"radio.max_rang": 0.2}, UnknownNameError, "max_range"),
        ({"seed": -1}, ConfigError, "-1"),
    ],
)
def test_a_bad_option_is_refused_by_name(options, error, message):
    with pytest.raises(error, match=message):
        SwarmVecEnv("es1", **options)


def test_attributes_and_methods_are_those_of_all_robots():
    env = make()
    assert env.get_attr("max_cycles", [0, 1]) == [18000, 18000]
    env.set_attr("max_cycles", 5)
    assert env.max_cycles == 5
    assert env.env_method("seed", 4, indices=[2]) == [[4] * 8]
    assert env.env_is_wrapped(VecMonitor) == [False] * 8


def test_waypoints_have_environments_too():
    env = SwarmVecEnv("waypoints-05", n_worlds=2, max_cycles=1)
    env.reset()
    observed, rewards, done, _ = env.step(zeros(env))
    assert observed.shape == (env.num_envs, *env.observation_space.shape)
    assert done.all()
    assert rewards.shape == (env.num_envs,)


def test_the_example_trains_two_iterations(capsys):
    main = runpy.run_path(str(EXAMPLE))["main"]
    model = main(2 * 256 * 80 * 5)
    assert model.num_timesteps == 2 * 256 * 80
    assert "total_timesteps" in capsys.readouterr().out
