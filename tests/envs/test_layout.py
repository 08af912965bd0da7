"""Layouts name every number, and turn observations back into what the layers see."""

import pickle
from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env import ConfigError
from swarm_forage_env.foraging.policies import LEARNABLE
from swarm_forage_env.swarm_forage_v0 import parallel_env

every_layer = pytest.mark.parametrize("learn", list(LEARNABLE))


@every_layer
def test_every_number_has_a_name_of_its_own_and_bounds(learn):
    env = parallel_env(learn=learn)
    layouts = [
        (env.observation_space("epuck_0"), env.observation_layout),
        (env.action_space("epuck_0"), env.action_layout),
        (env.state_space, env.state_layout),
    ]
    for space, layout in layouts:
        assert space.shape == (len(layout),)
        assert space.dtype == np.float32
        assert len(set(layout.names)) == len(layout)
        normal = [np.isfinite([each.low, each.high]).all() or each.scale for each in layout]
        assert all(normal)
        assert (space.low < space.high).all()
        assert all(slot.unit for slot in layout)


def test_a_number_has_the_same_name_whichever_layer_is_learned():
    slots = {learn: set(parallel_env(learn=learn).observation_layout) for learn in LEARNABLE}
    assert slots["both"] == slots["weighting"] | slots["motion"]


def test_a_layout_prints_as_a_table():
    lines = str(parallel_env(learn="weighting", range_noise=0.025).observation_layout).splitlines()
    assert lines[0].split() == ["name", "unit", "low", "high", "noise"]
    assert lines[1].split() == ["0", "encounter.valid", "0", "or", "1", "0", "1"]
    assert len(lines) == 1 + 20
    assert "+- 0.025 m, each frame" in next(line for line in lines if "encounter.range" in line)


def test_the_real_board_names_its_own_noise():
    layout = parallel_env("real", learn="weighting").observation_layout
    assert any("lognormal" in slot.noise for slot in layout)


@pytest.mark.parametrize("learn", ["weighting", "motion", "both"])
def test_an_observation_turns_back_into_what_the_layer_sees(learn, stacked, constant):
    env = parallel_env(learn=learn)
    env.reset(seed=2)
    still = constant(env, *[0.0] * len(env.action_layout))
    for _ in range(60):
        observations, *_ = env.step(still)
        matrix = stacked(observations)
        sees = {"encounter": env.array_env.loop.exchange, "situation": env.array_env.loop.situation}
        for part in env.observation_layout.parts:
            back = getattr(env.observation_layout, part)(matrix)
            for field in fields(back):
                value = getattr(back, field.name)
                assert value.flags.c_contiguous
                assert_array_equal(value, getattr(sees[part], field.name))


@pytest.mark.parametrize("goal", [-1, 0, 1])
def test_a_goal_takes_one_of_three_slots(goal, constant, stacked):
    env = parallel_env(learn="weighting")
    observations, _ = env.reset(seed=0)
    matrix = stacked(observations)
    columns = [env.observation_layout.names.index(f"encounter.goal.{g}") for g in ("nest", "prey")]
    none = env.observation_layout.names.index("encounter.goal.none")
    matrix[:, [*columns, none]] = 0.0
    matrix[:, none if goal < 0 else columns[goal]] = 1.0
    assert set(env.observation_layout.encounter(matrix).goal) == {goal}


@every_layer
def test_no_observation_of_a_robot_on_the_floor_is_all_zeros(learn):
    observations, _ = parallel_env(learn=learn).reset(seed=0)
    assert all(observation.any() for observation in observations.values())


def test_a_layout_survives_another_process():
    layout = parallel_env(learn="both").observation_layout
    again = pickle.loads(pickle.dumps(layout))
    assert again == layout
    assert again.names == layout.names
    assert set(again.parts) == {"encounter", "situation"}


def test_what_is_not_in_an_observation_is_refused(stacked):
    env = parallel_env(learn="weighting")
    observations, _ = env.reset(seed=0)
    with pytest.raises(ConfigError, match="holds no situation, only encounter"):
        env.observation_layout.situation(stacked(observations))
    with pytest.raises(ConfigError, match=r"shape \(20,\): must be \(robots, 20\)"):
        env.observation_layout.encounter(observations["epuck_0"])
