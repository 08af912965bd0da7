"""Bad input gets one exception that says which, what and what would do; nothing changes."""

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from numpy.testing import assert_array_equal

from swarm_forage_env import ConfigError, UnknownNameError
from swarm_forage_env.envs.array_env import ArrayEnv
from tests.commands import env, parallel_env
from training.vec_env import SwarmVecEnv


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"learn": "motoin"}, "no layer to learn named 'motoin', did you mean 'motion'"),
        ({"learn": "weighting", "residual": True}, "no layer to learn as a residual named 'weigh"),
        ({"reward": "teem"}, "no reward named 'teem', did you mean 'team'"),
        ({"controller": "sgikf"}, "no controller named 'sgikf', did you mean"),
        ({"controller": "ssgiff:beat=1"}, "no parameter of ssgiff named 'beat'"),
        ({"scenario": "es4"}, "no scenario named 'es4', did you mean 'es"),
        ({"physics": "rigit"}, "no physics engine named 'rigit', did you mean 'rigid'"),
        ({"radio.max_rnge": 0.2}, "named 'radio.max_rnge', did you mean 'radio.max_range'"),
        ({"lern": "motion"}, "no keyword or scenario parameter named 'lern', did you mean 'learn'"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(options, says):
    with pytest.raises(UnknownNameError, match=says):
        parallel_env(**options)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"learn": 3}, "learn=3"),
        ({"residual": 2}, "residual=2"),
        (
            {"residual": True, "scenario": "waypoints-05"},
            "residual=True: cannot be had in the task waypoints",
        ),
        ({"physics": ["rigid"]}, "physics="),
        ({"shaping": -1.0}, "shaping=-1.0: input should be greater than or equal to 0"),
        ({"shaping": float("nan")}, "shaping=nan"),
        ({"discount": 1.5}, "discount=1.5: input should be less than or equal to 1"),
        ({"decision_period": 0}, "decision_period=0"),
        ({"decision_period": 2.5}, "decision_period=2.5"),
        ({"decision_period": 18_001}, "must be at most the 18000 ticks"),
        ({"max_cycles": 0}, "max_cycles=0"),
        ({"max_cycles": 10**400}, r"max_cycles=10{39}\.\.\.: input should be less than"),
        (
            {"render_mode": "svg"},
            "render_mode='svg': must be one of 'human', 'rgb_array', 'ansi', or",
        ),
        ({"controller": "ssgiff:beta"}, "'beta' must be parameter=value"),
        ({"controller": 7}, "controller=7: must be a name or a controller"),
        ({"learn": "everything", "controller": "dsgiff"}, "'dsgiff': none runs where learn='every"),
        ({"learn": "weighting", "controller": "nc"}, "'nc': nobody talks, so that there is"),
        (
            {"learn": "weighting", "controller": "subsumption:estimator=dead_reckoning"},
            "'subsumption': nobody talks",
        ),
        ({"scenario": 7}, "scenario=7: must be a name, a TOML file or a Scenario"),
        ({"scenario": "none.toml"}, "scenario file none.toml"),
        ({"radio.max_range": -0.2}, "radio.max_range=-0.2"),
        ({"task.n_robots": 500}, "task.n_robots=500: at most"),
    ],
)
def test_a_value_that_cannot_be_used_is_refused(options, says):
    with pytest.raises(ConfigError, match=says):
        parallel_env(**options)


def test_a_scenario_of_the_users_own_comes_from_a_file_or_an_object(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('base = "es1"\n[task]\nn_robots = 3\n')
    assert parallel_env(file).possible_agents == ["epuck_0", "epuck_1", "epuck_2"]
    assert parallel_env(str(file), n_robots=4).scenario.task.n_robots == 4
    scenario = parallel_env(file).scenario
    assert parallel_env(scenario).scenario == scenario


@pytest.fixture
def running():
    made = parallel_env("es1", learn="motion", **{"task.n_robots": 3})
    made.reset(seed=0)
    made.step({agent: np.full(2, 0.5, np.float32) for agent in made.agents})
    return made


GOOD = [0.1, 0.2]


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"epuck_1": [1.0000001, 0.0]}, ConfigError, "epuck_1: wheels.left=1.0000001: must be"),
        ({"epuck_1": np.float32([0, -1.0000001])}, ConfigError, "right=-1.0000001: must be from"),
        ({"epuck_1": [np.nan, 0.0]}, ConfigError, "epuck_1: wheels.left=nan: must be from -1 to 1"),
        ({"epuck_1": [0.0, np.inf]}, ConfigError, "epuck_1: wheels.right=inf: must be from -1"),
        ({"epuck_2": [0.0, -1.5]}, ConfigError, "wheels.right=-1.5: must be .* clip it first"),
        ({"epuck_0": [0.0]}, ConfigError, r"epuck_0: shape \(1,\): must be \(2,\)"),
        ({"epuck_0": 0.0}, ConfigError, r"epuck_0: shape \(\): must be \(2,\)"),
        ({"epuck_0": [[0.0, 0.0]]}, ConfigError, r"epuck_0: shape \(1, 2\): must be \(2,\)"),
        ({"epuck_0": ["fast", "slow"]}, ConfigError, "epuck_0: .*: must be numbers, wheels.left"),
        ({"epuck_0": None}, ConfigError, "epuck_0: "),
        ({"epuck_0": [10**400, 0.0]}, ConfigError, "epuck_0: .*: too large; clip it first"),
        ({"epuck_0": 10**5000}, ConfigError, "epuck_0: <int of thousands of digits>: too large"),
        ({"epuck_0": [1j, 0.0]}, ConfigError, "epuck_0: .*: must be numbers, wheels.left"),
        ({"epuck_2": ...}, ConfigError, "epuck_2 has none; every agent needs one"),
        ({"epuck_3": GOOD}, UnknownNameError, "no agent named 'epuck_3', did you mean 'epuck_"),
        ({"epuck_0": [True, False]}, ConfigError, "actions: "),
    ],
)
def test_a_bad_action_is_refused_and_changes_nothing(running, change, error, says):
    good = dict.fromkeys(running.agents, np.array(GOOD, np.float32))
    merged = {agent: act for agent, act in {**good, **change}.items() if act is not ...}
    if change == {"epuck_0": [True, False]}:
        merged = dict.fromkeys(running.agents, np.array([True, False]))
    before = running.state()
    twin = parallel_env("es1", learn="motion", **{"task.n_robots": 3})
    twin.reset(seed=0)
    twin.step({agent: np.full(2, 0.5, np.float32) for agent in twin.agents})
    with pytest.raises(error, match=says):
        running.step(merged)
    assert_array_equal(running.state(), before)
    after, expected = running.step(good), twin.step(good)
    for agent in after[0]:
        assert_array_equal(after[0][agent], expected[0][agent])
    assert after[1:] == expected[1:]


@pytest.mark.parametrize("actions", [None, [GOOD] * 3, np.zeros((3, 2)), {}])
def test_actions_that_are_no_dictionary_or_empty_are_refused(running, actions):
    with pytest.raises(ConfigError, match="actions"):
        running.step(actions)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16, np.int64, list])
def test_any_kind_of_number_is_taken(running, kind):
    action = [1, -1] if kind is list else np.array([1, -1], kind)
    observations, *_ = running.step(dict.fromkeys(running.agents, action))
    assert observations["epuck_0"][-2:].tolist() == [1.0, -1.0]


def test_no_step_and_no_state_before_reset():
    fresh = parallel_env()
    with pytest.raises(ResetNeeded, match=r"call reset\(\) first"):
        fresh.step({})
    with pytest.raises(ResetNeeded, match=r"call reset\(\) first"):
        fresh.state()


def test_no_step_after_the_end(constant):
    short = parallel_env(max_cycles=2)
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


@pytest.mark.parametrize("choice", [[10**5000], RAGGED])
def test_a_choice_that_is_no_number_is_refused(choice):
    one = parallel_env("es1", discrete=True, **{"task.n_robots": 1})
    one.reset(seed=0)
    with pytest.raises(ConfigError, match=r"epuck_0: .*: must be a whole number from 0 to 4"):
        one.step({"epuck_0": choice})


@pytest.mark.parametrize("seed", [np.array(3), np.array(1.5)])
def test_a_seed_of_several_worlds_that_is_none_is_refused(seed):
    with pytest.raises(ConfigError, match=r"seed=.*: must be a whole number from 0"):
        MISUSED["vector"]().reset(seed=seed)


@pytest.mark.parametrize("seed", [-1, 1.5, 2**64, "one", True])
def test_a_bad_seed_is_refused(seed, running):
    before = running.state()
    with pytest.raises(ConfigError, match="seed="):
        running.reset(seed=seed)
    assert_array_equal(running.state(), before)


def test_unknown_options_of_reset_are_refused_but_that_of_pettingzoos_tests(running):
    before = running.state()
    with pytest.raises(UnknownNameError, match="no scenario parameter for an episode named 'col"):
        running.reset(seed=0, options={"colour": "red"})
    assert_array_equal(running.state(), before)
    running.reset(seed=0, options={"options": 1})
    assert len(running.agents) == 3


MISUSED = {
    "pettingzoo": lambda: parallel_env("es1"),
    "gymnasium": lambda: gymnasium.make("SwarmForage/ES1-v2").unwrapped,
    "vector": lambda: gymnasium.make_vec("SwarmForage/ES1-v2", num_envs=2),
    "array": lambda: ArrayEnv("es1", 2),
}


@pytest.mark.parametrize("made", MISUSED.values(), ids=MISUSED)
def test_options_and_snapshots_that_are_none_are_refused(made):
    misused = made()
    for options in (5, "x", [1], {5: 1}, {None: 1}, [("a", 1)], np.ones(3), True):
        with pytest.raises(ConfigError, match=r"options=.*must be numbers of the scenario by name"):
            misused.reset(options=options)
    misused.reset(seed=1)
    for snapshot in (5, None, (), (1, 2)):
        with pytest.raises(ConfigError, match=r"restore\(\): must be given what snapshot\(\)"):
            misused.restore(snapshot)


def test_a_step_of_the_batch_of_sb3_before_reset_is_refused():
    batch = SwarmVecEnv("es1", 2)
    with pytest.raises(ResetNeeded, match="call reset"):
        batch.step(np.zeros((batch.num_envs, *batch.action_space.shape)))


def test_an_unknown_agent_has_no_space(running):
    for space in (running.observation_space, running.action_space):
        with pytest.raises(UnknownNameError, match="no agent named 'epuck_9'"):
            space("epuck_9")
        for agent in ([], {}, None):
            with pytest.raises(UnknownNameError, match="no agent named"):
                space(agent)


def test_nothing_is_drawn(running):
    with pytest.raises(ConfigError, match="give render_mode='human', 'rgb_array' or 'ansi'"):
        running.render()
    running.close()


def test_agents_in_turn_clip_with_a_warning(caplog):
    turns = env(learn="motion", **{"task.n_robots": 1})
    turns.reset(seed=0)
    turns.step(np.array([2.0, 0.0], np.float32))
    assert "clipping to space" in caplog.text
    assert turns.last()[0][-2:].tolist() == [1.0, 0.0]


@pytest.mark.parametrize("option", ["physics", "action", "reward", "learn", "observation"])
def test_a_name_of_two_lines_is_refused_in_one(option):
    with pytest.raises(UnknownNameError, match=r"named 'es1\\n', known: ") as refusal:
        parallel_env("es1", **{option: "es1\n"})
    assert "\n" not in str(refusal.value)
