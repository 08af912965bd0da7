"""Observations: within [-1, 1] by typical sizes, with additions, and ones of the user's own."""

import math

import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env import ArrayEnv, ConfigError, UnknownNameError, parallel_env
from swarm_forage_env.foraging.policies import LEARNABLE
from swarm_forage_env.spaces import Feature
from tests.properties.test_any_scenario import A_FEW, scenarios

FEW = {"task.n_robots": 4, "physics": "kinematic"}


def steps(env, n, seed=0):
    """Observations and states of n random steps."""
    rng = np.random.default_rng(seed)
    seen = [env.reset(seed)[0]]
    states = [env.state()]
    for _ in range(n):
        shape = (env.n_worlds, len(env.learners), *env.action_shape)
        seen.append(env.step(rng.uniform(-1.0, 1.0, shape).astype(np.float32))[0])
        states.append(env.state())
    return np.stack(seen), np.stack(states)


@given(
    scenario=scenarios(),
    learn=st.sampled_from(list(LEARNABLE)),
    seed=st.integers(0, 2**64 - 1),
    decision_period=st.integers(1, 4),
    physics=st.sampled_from(["rigid", "kinematic"]),
    normalise=st.booleans(),
)
@settings(A_FEW, max_examples=25)
def test_whatever_the_scenario_no_number_is_nan_and_all_are_within_their_bounds(
    scenario, seed, normalise, **options
):
    env = parallel_env(scenario, reward="team", shaping=0.5, normalise=normalise, **options)
    for space in (env.observation_space("epuck_0"), env.state_space):
        assert np.abs([space.low, space.high]).max() == 1.0 or not normalise
    box, rng = env.action_space("epuck_0"), np.random.default_rng(seed)
    observations, _ = env.reset(seed=seed)
    for _ in range(12):
        for agent, observation in observations.items():
            assert env.observation_space(agent).contains(observation)  # NaN is in none
        assert env.state_space.contains(env.state())
        actions = rng.uniform(box.low, box.high, (len(env.agents), *box.shape))
        given_to = dict(zip(env.agents, actions.astype(np.float32), strict=True))
        observations, rewards, *_, infos = env.step(given_to)
        numbers = [*rewards.values(), *(n for info in infos.values() for n in info.values())]
        assert np.isfinite(numbers).all()


@pytest.mark.parametrize("learn", LEARNABLE)
def test_normalised_numbers_are_the_si_numbers_by_their_scales(learn, busy):
    plain, scaled = (
        ArrayEnv(busy, 1, learn=learn, normalise=flag, action="wheels", physics="kinematic")
        for flag in (False, True)
    )
    drive = np.full((1, 10, len(plain.action_layout)), 0.5, np.float32)
    same = drive.copy()
    if learn in ("weighting", "both"):
        same[:, :, :2] = 0.0  # g = 0.5 about zero
    si, ours = plain.reset(3)[0], scaled.reset(3)[0]
    for _ in range(80):
        for k, feature in enumerate(plain.observation_layout):
            x = si[0, :, k]
            by = np.abs(x) + feature.scale if feature.scale else feature.bound
            assert_allclose(ours[0, :, k], x / by, rtol=1e-6, err_msg=feature.name)
        si, ours = plain.step(drive)[0], scaled.step(same)[0]


@pytest.mark.parametrize("walk", [True, False])
def test_the_target_has_a_direction_of_length_one_and_without_a_walk_no_goal_has_none(walk, busy):
    env = ArrayEnv(busy, 4, walk=walk, physics="kinematic")
    at = env.observation_layout.names.index("situation.target.direction.x")
    goal = env.observation_layout.names.index("situation.goal.none")
    seen, _ = steps(env, 400)
    length = np.hypot(seen[..., at], seen[..., at + 1])
    has_goal = seen[..., goal] == 0.0
    assert has_goal.any()
    assert_allclose(length[has_goal], 1.0, atol=1e-5)
    assert_allclose(length[~has_goal], float(walk), atol=1e-5 * walk)


def test_additions_are_what_they_say():
    names = ["layer", "time_left", "robot_id", "one_hot", "previous_action"]
    env = ArrayEnv("es1", 2, observation=names, max_cycles=10, **FEW)
    bare = ArrayEnv("es1", 2, max_cycles=10, **FEW)
    n = len(bare.observation_layout)
    assert env.observation_layout.names[n:][:2] == ("time_left", "robot_id")
    seen, _ = env.reset(0)
    assert_array_equal(seen[..., :n], bare.reset(0)[0])
    assert_array_equal(seen[..., n], 1.0)
    assert_allclose(seen[0, :, n + 1], [0.0, 1 / 3, 2 / 3, 1.0])
    assert_array_equal(seen[1, :, n + 2 : n + 6], np.eye(4))
    assert_array_equal(seen[..., n + 6 :], 0.0)
    seen, *_ = env.step(np.zeros((2, 4, 2), np.float32))
    assert_allclose(seen[..., n], 0.9)
    assert_array_equal(seen[..., n + 6 :], 1.0)  # zeros drive at full speed


def test_frames_are_stacked_the_newest_last_and_a_reset_begins_anew():
    one, three = (ArrayEnv("es1", 2, stack=k, **FEW) for k in (1, 3))
    n = len(one.observation_layout)
    assert len(three.observation_layout) == 3 * n
    assert three.observation_layout.names[0].startswith("2 ago.")
    singles = [one.reset(0)[0]]
    seen = three.reset(0)[0]
    assert_array_equal(seen, np.tile(singles[0], 3))
    ahead = np.ones((2, 4, 2), np.float32)
    for _ in range(4):
        singles.append(one.step(ahead)[0])
        seen = three.step(ahead)[0]
    assert_array_equal(seen, np.concatenate(singles[-3:], axis=2))
    fresh, _ = one.reset(7, worlds=[1])
    seen, _ = three.reset(7, worlds=[1])
    assert_array_equal(seen[1], np.tile(fresh[1], 3))
    assert_array_equal(seen[0], np.concatenate(singles[-3:], axis=2)[0])


class Compass:
    """A heading, which no e-puck senses."""

    def features(self, scenario, agents):
        return [Feature("compass", "rad", -math.pi, math.pi)]

    def write(self, context, out):
        out[:, :, 0] = context.robots["pose"][:, :, 2]


def test_an_observation_of_ones_own_goes_in_without_touching_ours():
    alone = ArrayEnv("es1", 2, observation=Compass, **FEW)
    env = ArrayEnv("es1", 2, observation=["layer", Compass()], normalise=False, **FEW)
    heading = alone.reset(0)[0][..., 0] * math.pi
    assert alone.observation_layout.names == ("compass",)
    assert_allclose(heading, alone.world.robots["pose"][..., 2], rtol=1e-6)
    assert_allclose(env.reset(0)[0][..., -1], heading, rtol=1e-6)


class Noisy:
    """Numbers of two kinds for every robot."""

    def features(self, scenario, agents):
        return [Feature("normal", "m", -5.0, 5.0), Feature("uniform", "m", 1e-9, 1.0)]

    def write(self, context, out):
        out[:, :, 0] = context.normal(1)[:, :, 0]
        out[:, :, 1] = context.uniform(1)[:, :, 0]


def test_what_an_observation_draws_is_of_the_episode_alone():
    env = ArrayEnv("es1", 3, observation=Noisy, normalise=False, max_cycles=4, **FEW)
    seen, states = steps(env, 3, seed=5)
    assert_array_equal(steps(env, 3, seed=5)[0], seen)
    alone = ArrayEnv("es1", 1, observation=Noisy, normalise=False, max_cycles=4, **FEW)
    found, state = steps(alone, 3, seed=7)
    assert_array_equal(found[:, 0], seen[:, 2])
    assert_array_equal(state[0, 0], states[0, 2])
    assert len(np.unique(seen)) == seen.size
    assert abs(seen[..., 0]).max() > 1.0
    assert 0.0 <= seen[..., 1].min() < 0.1 < 0.9 < seen[..., 1].max() < 1.0


def test_streams_of_observations_stand_while_other_worlds_are_reset_and_are_in_snapshots():
    env = ArrayEnv("es1", 2, observation=Noisy, normalise=False, **FEW)
    still = np.zeros((2, 4, 2), np.float32)
    env.reset(3)
    expected = [env.step(still)[0] for _ in range(2)]
    begun, _ = env.reset(3)
    kept = env.snapshot()
    assert_array_equal(env.reset([9], worlds=[1])[0][0], begun[0])
    first = env.step(still)[0]
    assert_array_equal(first[0], expected[0][0])
    assert (first[1] != expected[0][1]).all()
    env.restore(kept)
    for each in expected:
        assert_array_equal(env.step(still)[0], each)


@pytest.mark.parametrize(
    ("observation", "error", "message"),
    [
        ("layers", UnknownNameError, "no observation named 'layers', did you mean 'layer'"),
        ([], ConfigError, r"observation=\[\]"),
        (7, ConfigError, "observation=7: must be 'layer'"),
        ([Compass, Compass], ConfigError, "repeated: .'compass'."),
    ],
)
def test_what_is_no_observation_is_refused(observation, error, message):
    with pytest.raises(error, match=message):
        parallel_env("es1", observation=observation)


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (np.nan, ConfigError, "compass: is nan for learner 0 of world 0, must be .*from -3.14159"),
        (7.0, ConfigError, "compass: is 7.0 for learner 0 of world 0"),
        (None, ValueError, "read-only"),
        ("", ConfigError, "Broken: `write` returned a value, must write features into"),
    ],
)
def test_wrong_numbers_of_an_observation_do_not_travel_nor_move_robots(value, error, message):
    class Broken(Compass):
        def write(self, context, out):
            assert not out.any(), "what it does not write is zero"
            out[...] = value or 0.0
            if value is None:
                context.robots["pose"][..., 0] += 1.0
            return out if value else out + 1.0

    env = parallel_env("es1", observation=["layer", Broken], **FEW)
    with pytest.raises(error, match=message):
        env.reset(seed=0)
    with pytest.raises(ResetNeeded, match="interrupted by an exception: call reset"):
        env.step({})


@pytest.mark.parametrize(
    ("features", "message"),
    [
        (lambda: Feature("x", "m", 1.0, 0.0), "feature x: low=1.0 must be at most 0.0"),
        (lambda: Feature("x", "m", 0.0, 1.0, scale=0.0), "feature x: scale=0.0 must be above 0"),
        (lambda: [Feature("x", "m", -9.0, np.inf)], "give no typical size; give the feature"),
        (lambda: "x", "observation Broken: features gave 'x', must be a list of Feature"),
    ],
)
def test_what_are_no_features_is_refused(features, message):
    class Broken(Compass):
        def features(self, scenario, agents):
            return features()

    with pytest.raises(ConfigError, match=message):
        parallel_env("es1", observation=Broken)
