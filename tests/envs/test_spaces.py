"""Every number stays within its bounds, whatever the policy does."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_forage_env.foraging.policies import LEARNABLE
from tests.commands import parallel_env


def assert_within(space, value):
    assert not np.isnan(value).any()
    outside = (value < space.low) | (value > space.high)
    assert not outside.any(), np.flatnonzero(outside)
    assert space.contains(value)


def assert_all_within(env, observations):
    for agent, observation in observations.items():
        assert_within(env.observation_space(agent), observation)
    assert_within(env.state_space, env.state())


@given(
    learn=st.sampled_from(list(LEARNABLE)),
    seed=st.integers(0, 2**64 - 1),
    decision_period=st.integers(1, 4),
    physics=st.sampled_from(["rigid", "kinematic"]),
    options=st.fixed_dictionaries(
        {
            "task.n_robots": st.integers(1, 12),
            "task.duration": st.floats(5.0, 100.0),
            "radio.max_range": st.floats(0.02, 1.0),
            "radio.range_noise": st.floats(0.0, 0.2),
            "radio.bearing_noise": st.floats(0.0, math.pi),
            "radio.range_model": st.sampled_from(["uniform", "board"]),
            "radio.frames": st.integers(1, 30),
            "radio.slots": st.integers(1, 8),
            "radio.exchange_time": st.floats(0.01, 2.0),
            "sensors.wheel_noise": st.floats(0.0, 1.0),
            "sensors.ground_noise": st.floats(0.0, 1.0),
            "sensors.proximity_noise": st.floats(0.0, 1.0),
            "robot.cruise_speed": st.floats(0.01, 0.129),
            "area_distance": st.floats(0.62, 1.4),
        }
    ),
)
@settings(max_examples=25)
def test_whatever_the_scenario_nothing_is_nan_and_all_is_within_bounds(
    learn, seed, decision_period, physics, options
):
    env = parallel_env(
        "es1", learn=learn, reward="team", shaping=0.5,
        decision_period=decision_period, physics=physics, **options,
    )  # fmt: skip
    box, rng = env.action_space("epuck_0"), np.random.default_rng(seed)
    observations, _ = env.reset(seed=seed)
    for _ in range(12):
        assert_all_within(env, observations)
        actions = rng.uniform(box.low, box.high, (len(env.agents), *box.shape))
        given_to = dict(zip(env.agents, actions.astype(np.float32), strict=True))
        observations, rewards, *_, infos = env.step(given_to)
        numbers = [*rewards.values(), *(n for info in infos.values() for n in info.values())]
        assert np.isfinite(numbers).all()


def test_the_spaces_are_the_same_objects_each_time():
    env = parallel_env()
    assert env.observation_space("epuck_3") is env.observation_space("epuck_3")
    assert env.action_space("epuck_3") is env.action_space("epuck_3")
    assert set(env.observation_spaces) == set(env.action_spaces) == set(env.possible_agents)
