"""Bad input gets one exception that says which, what and what would do; nothing changes."""

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.error import ResetNeeded
from numpy.testing import assert_array_equal

from swarm_forage_env import ConfigError, UnknownNameError
from swarm_forage_env.envs.array_env import ArrayEnv
from tests.commands import env, parallel_env
from training.vec_env import SwarmVecEnv


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"learn": "motoin"}, "no layer to learn named 'motoin', did you mean 'motion'"),
        ({"learn": "weighting", "residual": True}, "no layer to learn as a residual named 'weigh"),
        ({"reward": "teem"}, "no reward named 'teem', did you mean 'team'"),
        ({"radio.max_rnge": 0.2}, "named 'radio.max_rnge', did you mean 'radio.max_range'"),
        ({"lern": "motion"}, "no keyword or scenario parameter named 'lern', did you mean 'learn'"),
        ({"learn": "es1\n"}, r"named 'es1\\n', known: "),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest_in_a_line(options, message):
    with pytest.raises(UnknownNameError, match=rf"^[^\n]*{message}[^\n]*$"):
        parallel_env(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"learn": 3}, "learn=3"),
        ({"residual": 2}, "residual=2"),
        ({"residual": True, "scenario": "waypoints-05"}, "is not available in the task waypoints"),
        ({"shaping": -1.0}, "shaping=-1.0: must be greater than or equal to 0"),
        ({"shaping": float("nan")}, "shaping=nan"),
        ({"discount": 1.5}, "discount=1.5: must be less than or equal to 1"),
        ({"decision_period": 2.5}, "decision_period=2.5"),
        ({"decision_period": 18_001}, "must be at most the 18000 ticks"),
        ({"max_cycles": 0}, "max_cycles=0"),
        ({"n_robots": 3, "task.n_robots": 4}, "task.n_robots: is given twice, as 'n_robots' and"),
        ({"scenario": "aggregation", "spot_distance": 0.5}, "area about .* overlaps another one"),
        ({"scenario": "aggregation", "spot_radius": 1.0}, "lies outside the arena; change the"),
        ({"n_worlds": 3}, "n_worlds=3: is for ArrayEnv, SwarmVecEnv and SwarmTorchEnv; leave it"),
        ({"max_cycles": 10**400}, r"max_cycles=10{39}\.\.\.: must be less than"),
        ({"render_mode": "svg"}, "render_mode='svg': must be one of 'human', 'rgb_array', 'ansi'"),
        ({"controller": 7}, "controller=7: must be a name or a controller"),
        ({"learn": "weighting", "controller": "nc"}, "'nc': its robots exchange nothing that"),
        (
            {"learn": "weighting", "controller": "subsumption:estimator=dead_reckoning"},
            "'subsumption': its robots exchange nothing",
        ),
    ],
)
def test_a_value_that_cannot_be_used_is_refused(options, message):
    with pytest.raises(ConfigError, match=message):
        parallel_env(**options)


AGENTS = "epuck_0", "epuck_1", "epuck_2"
GOOD = [0.1, 0.2]


def three_robots():
    made = parallel_env("es1", learn="motion", **{"task.n_robots": 3})
    made.reset(seed=0)
    made.step(dict.fromkeys(AGENTS, np.full(2, 0.5, np.float32)))
    return made


@pytest.fixture
def running():
    return three_robots()


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"epuck_1": [1.0000001, 0.0]}, ConfigError, "epuck_1: wheels.left=1.0000001: must be"),
        ({"epuck_1": [np.nan, 0.0]}, ConfigError, "epuck_1: wheels.left=nan: must be from -1 to 1"),
        ({"epuck_2": [0.0, -1.5]}, ConfigError, "wheels.right=-1.5: must be .* clip it first"),
        ({"epuck_0": [0.0]}, ConfigError, r"epuck_0: shape \(1,\): must be \(2,\)"),
        (
            {"epuck_0": ["fast", "slow"]},
            ConfigError,
            "epuck_0: .*: must be finite numbers, wheels.left",
        ),
        ({"epuck_0": None}, ConfigError, "epuck_0: "),
        ({"epuck_0": torch.zeros(2, requires_grad=True)}, ConfigError, "epuck_0: .*requires grad"),
        ({"epuck_0": 10**5000}, ConfigError, "epuck_0: <int of thousands of digits>: must be fin"),
        ({"epuck_2": ...}, ConfigError, "epuck_2 has none; every agent needs one"),
        ({"epuck_3": GOOD}, UnknownNameError, "no agent named 'epuck_3', did you mean 'epuck_"),
        (dict.fromkeys(AGENTS, np.array([True, False])), ConfigError, "booleans"),
    ],
)
def test_a_bad_action_is_refused_and_changes_nothing(running, change, error, message):
    good = dict.fromkeys(AGENTS, np.array(GOOD, np.float32))
    merged = {agent: act for agent, act in {**good, **change}.items() if act is not ...}
    before = running.state()
    twin = three_robots()
    with pytest.raises(error, match=message):
        running.step(merged)
    assert_array_equal(running.state(), before)
    after, expected = running.step(good), twin.step(good)
    for agent in after[0]:
        assert_array_equal(after[0][agent], expected[0][agent])
    assert after[1:] == expected[1:]


@pytest.mark.parametrize("actions", [None, [GOOD] * 3, np.zeros((3, 2)), {}])
def test_actions_that_are_no_dictionary_or_empty_are_refused(running, actions):
    with pytest.raises(ConfigError, match=r"^actions[^\n]*$"):
        running.step(actions)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16, np.int64, list])
def test_any_kind_of_number_is_taken(running, kind):
    action = [1, -1] if kind is list else np.array([1, -1], kind)
    observations, *_ = running.step(dict.fromkeys(running.agents, action))
    assert observations["epuck_0"][-2:].tolist() == [1.0, -1.0]


def test_no_step_state_or_frame_before_the_first_reset_and_no_step_after_the_end(constant):
    short = parallel_env(max_cycles=2)
    for call in (short.state, short.render, lambda: short.step({})):
        with pytest.raises(ResetNeeded, match=r"call reset\(\) first"):
            call()
    short.reset(seed=0)
    still = constant(short, 0.0, 0.0)
    short.step(still)
    short.step(still)
    last = short.state()
    for actions in (still, {}):
        with pytest.raises(ResetNeeded, match=r"after the end, at 2 cycles"):
            short.step(actions)
    assert_array_equal(short.state(), last)
    short.reset()
    assert len(short.agents) == 10


RAGGED = [[0.0, 0.0], [0.0]]
HUGE = [[10**400, 0.0]] * 6


@pytest.mark.parametrize("actions", [RAGGED, [RAGGED] * 2, HUGE, [HUGE[:3]] * 2])
@pytest.mark.parametrize("made", [ArrayEnv, SwarmVecEnv])
def test_rows_that_are_no_array_of_numbers_are_refused_in_a_line(made, actions):
    batch = made("es1", 2, **{"task.n_robots": 3})
    batch.reset()
    with pytest.raises(ConfigError, match=r"^action[^\n]*$"):
        batch.step(actions)


MISUSED = {
    "pettingzoo": lambda: parallel_env("es1"),
    "gymnasium": lambda: gymnasium.make("SwarmForage/ES1-v2").unwrapped,
    "vector": lambda: gymnasium.make_vec("SwarmForage/ES1-v2", num_envs=2),
    "array": lambda: ArrayEnv("es1", 2),
}


@pytest.mark.parametrize("made", MISUSED.values(), ids=MISUSED)
def test_options_and_snapshots_that_are_none_are_refused(made):
    misused = made()
    for options in (5, "x", [1], {5: 1}, {None: 1}, [("a", 1)], np.ones((3, 2)), True):
        with pytest.raises(ConfigError, match=r"^options=.*must be a dictionary of scenario param"):
            misused.reset(options=options)
    misused.reset(seed=1)
    for snapshot in (5, None, (), (1, 2)):
        with pytest.raises(ConfigError, match=r"restore\(\): must be given the result of snap"):
            misused.restore(snapshot)


def test_an_unknown_agent_has_no_space(running):
    for space in (running.observation_space, running.action_space):
        for agent, said in (("epuck_9", "'epuck_9'"), ([], r"'\[\]'"), (None, "'None'")):
            with pytest.raises(UnknownNameError, match=f"no agent named {said}"):
                space(agent)


def test_agents_in_turn_clip_with_a_warning(caplog):
    turns = env(learn="motion", **{"task.n_robots": 1})
    turns.reset(seed=0)
    turns.step(np.array([2.0, 0.0], np.float32))
    assert "clipping to space" in caplog.text
    assert turns.last()[0][-2:].tolist() == [1.0, 0.0]
