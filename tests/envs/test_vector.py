"""Worlds in one block are so many single environments, step for step and bit for bit."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode
from numpy.testing import assert_array_equal

import tests.commands  # noqa: F401 enters its ids
from swarm_forage_env import ArrayEnv, ConfigError

WORLDS = 3
SINGLE, JOINT = "Commands/ES1-v0", "Commands/ES1-Joint-v0"
BUSY = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.02}
EXCHANGES = {"learn": "weighting", "step_on": "exchange"}


def in_one_block(made, mode="NextStep", **options):
    return gym.make_vec(made, num_envs=WORLDS, autoreset_mode=mode, **options)


def one_by_one(made, mode="NextStep", **options):
    how = {"vectorization_mode": "sync", "vector_kwargs": {"autoreset_mode": mode}}
    return gym.make_vec(made, num_envs=WORLDS, **how, **options)


def assert_same(ours, theirs, what):
    for one, other in zip(ours, theirs, strict=True):
        assert data_equivalence(one, other, exact=True), what


def assert_equal_for(steps, block, single):
    """Two resets with and without a seed, and so many random steps; how often all ended."""
    rng, ends, box = np.random.default_rng(0), 0, block.action_space
    for kind in ("action", "observation"):
        for name in (f"{kind}_space", f"single_{kind}_space"):
            assert getattr(block, name) == getattr(single, name)
    for seed in (11, None, [5, None, 3]):
        assert_same(block.reset(seed=seed), single.reset(seed=seed), f"reset with seed {seed}")
        assert block.np_random_seed == single.np_random_seed
        for step in range(steps):
            actions = rng.uniform(box.low, box.high).astype(np.float32)
            ours, theirs = block.step(actions), single.step(actions)
            assert_same(ours, theirs, f"step {step} after seed {seed}")
            ends += int(ours[3].all())
    return ends


@pytest.mark.parametrize(
    ("made", "options", "mode"),
    [
        (SINGLE, {"learn": "motion", "shaping": 1.0, **BUSY}, "NextStep"),
        (SINGLE, {"learn": "weighting", "reward": "team", **BUSY}, "SameStep"),
        (SINGLE, {"learn": "both", "decision_period": 2, "controller": "dsgiff"}, "NextStep"),
        (JOINT, {"learn": "motion", "shaping": 0.3, **BUSY}, "SameStep"),
        (JOINT, {"learn": "weighting", "shaping": 0.3, "reward": "team", **BUSY}, "NextStep"),
        (JOINT, {"learn": "everything"}, "NextStep"),
        ("Commands/Waypoints-05-v0", {"learn": "motion", "shaping": 1.0}, "SameStep"),
        ("Commands/Waypoints-10-Joint-v0", {"learn": "both"}, "NextStep"),
    ],
)
def test_a_block_is_its_single_environments(made, options, mode):
    options = {"max_cycles": 60, **options}
    block, single = in_one_block(made, mode, **options), one_by_one(made, mode, **options)
    assert block.metadata["render_modes"] == single.envs[0].unwrapped.metadata["render_modes"]
    assert assert_equal_for(150, block, single) == 3 * 2


@pytest.mark.parametrize(("most", "cycles"), [(4, 7), (7, 4), (-1, 4)])
def test_the_shorter_of_time_limit_and_max_cycles_ends_the_episodes(most, cycles):
    terms = {"max_episode_steps": most, "max_cycles": cycles, "observation": "time_left"}
    block, single = in_one_block(SINGLE, **terms), one_by_one(SINGLE, **terms)
    assert assert_equal_for(15, block, single) == 3 * 3
    assert assert_equal_for(15, pickle.loads(pickle.dumps(block)), single) == 3 * 3


def test_robots_that_share_a_policy_are_rows_of_their_worlds():
    made, options = "SwarmForage/ES1-Shared-v2", {"max_cycles": 9, "learners": 2, "reward": "team"}
    robots = gym.make_vec(made, num_envs=6, autoreset_mode="SameStep", shaping=1.0, **options)
    worlds, rng = ArrayEnv("es1", 3, shaping=1.0, **options), np.random.default_rng(0)
    observed, _ = robots.reset(seed=5)
    assert_array_equal(observed, worlds.reset(seed=5)[0].reshape(6, -1))
    for step in range(1, 19):
        actions = rng.uniform(-1.0, 1.0, robots.action_space.shape).astype(np.float32)
        observed, rewards, _, truncated, infos = robots.step(actions)
        expected, rewarded, _, over, _ = worlds.step(actions.reshape(3, 2, -1))
        if over.all():
            assert_array_equal(np.stack(infos["final_obs"]), expected.reshape(6, -1))
            for k, name in enumerate(worlds.infos):
                assert_array_equal(infos["final_info"][name], worlds.log()[:, :, k].ravel())
            expected, _ = worlds.reset()
        assert_array_equal(observed, expected.reshape(6, -1))
        assert_array_equal(rewards, rewarded.ravel())
        assert truncated.tolist() == [step % 9 == 0] * 6


def test_robots_that_share_a_policy_are_reset_with_their_world():
    made, options = "SwarmForage/Near-Shared-v2", {"render_mode": "ansi", "max_cycles": 1}
    robots = gym.make_vec(made, num_envs=10, autoreset_mode="Disabled", **options)
    robots.reset(seed=0)
    with pytest.raises(ConfigError, match=r"must be \(10, 2\), one for each robot"):
        robots.step(np.zeros((2, 2)))
    ended = robots.step(np.zeros((10, 2)))[3]
    mask = ended & (np.arange(10) < 5)
    robots.reset(options={"reset_mask": mask})
    assert len(set(robots.render()[:5])) == 1
    assert robots.render()[0] != robots.render()[5]
    with pytest.raises(ConfigError, match="robots of a world are reset together"):
        robots.reset(options={"reset_mask": np.arange(10) < 4})
    with pytest.raises(ConfigError, match=r"use gym\.make_vec, or the id without -Shared"):
        gym.make(made)
    with pytest.raises(ConfigError, match=r"num_envs=12: .*a multiple of 5"):
        gym.make_vec(made, num_envs=12)


def test_without_autoreset_the_end_is_the_end():
    block = in_one_block(SINGLE, "Disabled", max_episode_steps=1)
    block.reset(seed=0, options={"reset_mask": np.ones(WORLDS, bool)})
    still = np.zeros(block.action_space.shape, np.float32)
    assert block.step(still)[3].all()
    with pytest.raises(ResetNeeded, match="after the end of world 0, at 1 cycles"):
        block.step(still)
    block.reset(options={"task.area_distance": 1.0})
    block.step(still)


def test_without_autoreset_some_worlds_are_reset_by_a_mask():
    block, twin = (in_one_block(SINGLE, "Disabled", max_cycles=6) for _ in range(2))
    still = np.full(block.action_space.shape, 0.3, np.float32)
    for each in (block, twin):
        each.reset(seed=0)
        for _ in range(4):
            each.step(still)
    mask = np.arange(WORLDS) == 1
    fresh, _ = block.reset(seed=7, options={"reset_mask": mask})
    begun, _ = in_one_block(SINGLE, "Disabled").reset(seed=7)
    assert_array_equal(fresh[1], begun[1])
    for _ in range(2):
        ours, theirs = block.step(still), twin.step(still)
        assert_array_equal(ours[0][~mask], theirs[0][~mask])
    assert_array_equal(ours[3], ~mask)


@pytest.mark.parametrize(
    ("mode", "mask", "message"),
    [
        ("NextStep", [True, False, True], "none is reset alone; use autoreset_mode='Disabled'"),
        ("Disabled", [True], "must be a mask of 3 worlds"),
        ("Disabled", [1, 0, 1], "must be a mask of 3 worlds"),
    ],
)
def test_a_mask_that_does_not_fit_is_refused(mode, mask, message):
    block = in_one_block(SINGLE, mode)
    with pytest.raises(ConfigError, match=message):
        block.reset(options={"reset_mask": np.array(mask)})


@pytest.mark.parametrize("mode", AutoresetMode)
def test_a_block_is_made_again_from_its_spec_and_says_how_episodes_follow(mode):
    block = in_one_block(JOINT, mode, learn="weighting", max_cycles=9)
    again = gym.make_vec(block.spec)
    assert (again.num_envs, again.max_cycles) == (WORLDS, 9)
    assert again.metadata == block.metadata
    assert again.metadata["autoreset_mode"] is mode
    assert gym.make_vec(SINGLE).metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert_array_equal(again.reset(seed=3)[0], block.reset(seed=3)[0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_envs": 0}, "num_envs=0: must be a whole number, at least 1"),
        ({"max_episode_steps": 0}, "max_episode_steps=0: must be"),
        ({"max_episode_steps": 5, **EXCHANGES}, "max_episode_steps=5: under .* use max_cycles"),
        ({"num_envs": 2, "stagger": True}, "stagger=True: worlds end .*='Disabled'"),
        ({"num_envs": 2, **EXCHANGES}, "step_on='exchange': worlds end at .*='sync'"),
        ({"num_envs": 2, "render_mode": "human"}, "one window shows one world, not 2"),
        ({"num_envs": 2, "device": "cpu"}, "device='cpu': is for ArrayEnv"),
        ({"autoreset_mode": "never"}, "'never': must be one of 'NextStep', 'SameStep', 'Disabled'"),
    ],
)
def test_a_value_that_cannot_be_used_is_refused(options, message):
    with pytest.raises(ConfigError, match=message):
        gym.make_vec(SINGLE, **options)


@pytest.mark.parametrize("seed", [-1, 2**64 - 1, [1, 2], [1, 2, -3], np.array(1.5)])
def test_a_bad_seed_is_refused_and_changes_nothing(seed):
    block, twin = in_one_block(SINGLE), in_one_block(SINGLE)
    block.reset(seed=1)
    twin.reset(seed=1)
    with pytest.raises(ConfigError, match="seed="):
        block.reset(seed=seed)
    assert_array_equal(block.reset()[0], twin.reset()[0])


@pytest.mark.parametrize("actions", [None, np.zeros(6)])
def test_actions_of_another_shape_are_refused(actions):
    block = in_one_block(SINGLE)
    block.reset(seed=1)
    with pytest.raises(ConfigError, match=r"must be \(3, 2\), one for each world"):
        block.step(actions)


def test_what_was_returned_is_not_written_to_again():
    block = in_one_block(JOINT)
    first, _ = block.reset(seed=0)
    kept = first.copy()
    action = np.full(block.action_space.shape, 0.5, np.float32)
    seen, *_ = block.step(action)
    assert_array_equal(first, kept)
    assert not np.shares_memory(seen, block.step(action)[0])
