"""Layouts name every number, and where what the layers see stands in an observation."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.foraging.policies import LEARNABLE
from tests.commands import parallel_env
from tests.outside import shown_records


@pytest.mark.parametrize("learn", LEARNABLE)
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
    board = parallel_env("real", learn="weighting").observation_layout
    assert "lognormal" in str(board)


@pytest.mark.parametrize("learn", ["weighting", "motion", "both"])
def test_an_observation_turns_back_into_what_the_layer_sees(learn, constant):
    env = parallel_env(learn=learn)
    layout = pickle.loads(pickle.dumps(env.observation_layout))  # as in another process
    assert layout == env.observation_layout
    env.reset(seed=2)
    still = constant(env, *[0.0] * len(env.action_layout))
    for _ in range(60):
        observations, *_ = env.step(still)
        loop, state = env.array_env.loop, env.world.state
        sees = {"exchange": loop.exchange, "situation": loop.situation, "heard": state.heard,
                "readings": state.readings, "command": state.command}  # fmt: skip
        seen = shown_records(layout, observations)
        for path in layout.paths:
            record = path.source.rpartition(".")[2]
            shown, known = seen[record][path.name], sees[record][path.name]
            assert_array_equal(shown, known[:, : shown.shape[1]] if record == "heard" else known)
        assert "heard" not in seen or (seen["heard"].n == sees["heard"].n).all()
        assert_array_equal(layout.matrix(seen), list(observations.values()))
