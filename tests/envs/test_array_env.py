"""The batch API: worlds side by side, each of which is the same world alone."""

import copy
import pickle
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from numpy.testing import assert_array_equal

from baselines.evaluation.experiment_config import find_layered_controller
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env import ArrayEnv, ConfigError, UnknownNameError, parallel_env, worlds_on_cpu
from tests.outside import OutsideMotionPart

OUTSIDE = replace(
    find_layered_controller("ssgikf"), motion=OutsideMotionPart(SubsumptionParameters())
)
"""A controller whose motion is a rule in Python."""

SHORT = {"task.n_robots": 4, "max_cycles": 12}


def actions_of(env, rng):
    shape = (env.n_worlds, len(env.learners), *env.action_shape)
    return rng.uniform(-1.0, 1.0, shape).astype(np.float32)


def begun(n_worlds, seed=0, **options):
    """A batch of short episodes that have begun."""
    env = ArrayEnv("es1", n_worlds, **{**SHORT, **options})
    env.reset(seed=seed)
    return env


def run(env, n):
    """What n steps give; worlds that end are reset."""
    rng, found = np.random.default_rng(0), []
    for _ in range(n):
        seen, rewards, terminated, truncated, infos = env.step(actions_of(env, rng))
        assert not terminated.any()
        found += [seen, rewards, truncated, infos["unshaped_reward"], env.log(), env.state()]
        found.append(env.reset(worlds=truncated)[0])
        assert_array_equal(found[-1][~truncated], seen[~truncated])
    return found


def assert_same(one, other):
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        assert_array_equal(a, b)


def test_staggered_worlds_end_one_after_the_other():
    env, rng, ends = begun(4, stagger=True), np.random.default_rng(0), []
    for step in range(1, 25):
        truncated = env.step(actions_of(env, rng))[3]
        ends += [(step, int(w)) for w in np.flatnonzero(truncated)]
        if truncated.any():
            env.reset(worlds=truncated)
    assert ends == [(3 * k, (k - 1) % 4) for k in range(1, 9)]
    env.reset(seed=0)
    assert env.episodes.ends.tolist() == [3, 6, 9, 12]


def test_a_world_must_be_reset_before_its_first_step_and_when_it_is_over():
    env, half = (ArrayEnv("es1", 2, stagger=True, **SHORT) for _ in range(2))
    half.reset(worlds=[1])
    for each in (env, half):
        with pytest.raises(ResetNeeded, match="has not begun"):
            each.step(np.zeros((2, 4, 2), np.float32))
    env.reset(seed=0)
    with pytest.raises(ConfigError, match=r"shape \(8, 2\): must be \(2, 4, 2\)"):
        env.step(np.zeros((8, 2), np.float32))
    for _ in range(6):
        env.step(np.zeros((2, 4, 2), np.float32))
    with pytest.raises(ResetNeeded, match="after the end of world 0, at 6 cycles"):
        env.step(np.zeros((2, 4, 2), np.float32))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"worlds": [2]}, r"worlds=\[2\]: must be a mask of 2 worlds, or different indices from 0"),
        ({"worlds": [True]}, "must be a mask of 2"),
        ({"worlds": "all"}, "must be a mask of 2"),
        ({"worlds": [0, 0]}, "must be a mask of 2"),
        ({"seed": [1]}, r"seed=\[1\]: must be 2 seeds, one for each world"),
        ({"seed": -1}, "seed=-1"),
        ({"options": {"task.n_robots": 3}}, "is the same in all episodes; set it when"),
        ({"options": {"task.area_distance": 9.0}}, "task.area_distance=9.0"),
    ],
)
def test_a_bad_reset_is_refused_and_changes_nothing(arguments, message):
    env, twin = begun(2), begun(2)
    with pytest.raises(ConfigError, match=message):
        env.reset(**arguments)
    assert_same(run(env, 13), run(twin, 13))  # into the next episodes


def test_options_hold_for_an_episode_and_unknown_ones_are_refused():
    env = parallel_env("es1", **SHORT)
    env.reset(seed=0, options={"task.area_distance": 1.0})
    direct = parallel_env("es1", **SHORT, **{"task.area_distance": 1.0})
    direct.reset(seed=0)
    assert_array_equal(env.state(), direct.state())
    assert env.scenario.task.area_distance == 1.0
    env.reset(seed=0)
    assert env.scenario.task.area_distance == 1.5
    with pytest.raises(UnknownNameError, match="named 'area_distanc', did you mean"):
        env.reset(options={"area_distanc": 1.0})
    with pytest.raises(ConfigError, match=r"ground.left would go from 0 to 1.92 brightness, but"):
        env.reset(options={"sensors.ground_noise": 0.9})
    with pytest.raises(ConfigError, match=r"_0.pose.x would go from -2 to 2 m, but in the state"):
        env.reset(options={"arena.length": 4.0})


def test_numbers_are_drawn_anew_for_each_world_and_episode():
    ranges = {"task.area_distance": (0.8, 1.4), "sensors.wheel_noise": (0.0, 0.1)}
    env = begun(3, randomise=ranges)
    (_, first), (_, second) = env.reset(seed=0), env.reset()
    assert all(len({*first[name], *second[name]}) == 6 for name in ranges)
    distances = [each.task.area_distance for each in env.world.scenarios]
    assert_array_equal(second["task.area_distance"], distances)
    for turned in ({"seed": 0}, {"seed": [2, 0], "worlds": [2, 0]}):
        assert_same(first.values(), env.reset(**turned)[1].values())
    alone = begun(1, seed=1, **{name: first[name][1] for name in ranges})
    straight = np.full((3, 4, 2), 0.3, np.float32)
    assert_array_equal(env.step(straight)[0][1], alone.step(straight[:1])[0][0])
    assert_same(second.values(), env.reset()[1].values())


@pytest.mark.parametrize("normalise", [True, False])
def test_randomised_numbers_stay_within_the_spaces(normalise):
    ranges = {"arena.length": (1.7, 4.0), "radio.max_range": (0.05, 0.6)}
    env, rng = ArrayEnv("es1", 4, randomise=ranges, normalise=normalise), np.random.default_rng(0)
    for episode in range(3):
        seen, _ = env.reset(seed=episode)
        for _ in range(20):
            for row in seen.reshape(-1, seen.shape[2]):
                assert env.observation_space.contains(row)
            for row in env.state():
                assert env.state_space.contains(row)
            seen = env.step(actions_of(env, rng))[0]


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"physics": "kinematic", "stack": 2, "shaping": 1.0},
        {"learn": "everything"},
        {"learn": "weighting", "randomise": {"task.area_distance": (0.8, 1.4)}},
        {"learn": "weighting", "controller": "learned-motion", "task.n_robots": 10},
    ],
)
def test_a_copy_and_a_snapshot_in_mid_episode_go_on_bit_for_bit(options):
    env = begun(2, max_cycles=40, **options)
    run(env, 30)
    kept, other = pickle.dumps(env.snapshot()), copy.deepcopy(env)
    first = run(env, 30)
    assert_same(first, run(other, 30))
    env.restore(pickle.loads(kept))
    assert_same(first, run(env, 30))


OTHER = [{"learn": "both"}, {"stack": 2}, {"controller": "nc"}, {"n_worlds": 3}]
OTHER += [{"decision_period": 5}, {"randomise": {"radio.max_range": (0.1, 0.2)}}]
OTHER += [{"max_cycles": 9}, {"residual": True}, {"action": "course"}, {"reflexes": False}]


@pytest.mark.parametrize("options", OTHER)
def test_a_snapshot_of_another_environment_is_refused_and_changes_nothing(options):
    env, twin = begun(2), begun(2)
    with pytest.raises(ConfigError, match=r"with other options|cannot be restored"):
        env.restore(begun(**{"n_worlds": 2, **options}).snapshot())
    assert_same(run(env, 5), run(twin, 5))


def test_what_a_step_gives_may_be_written_to_and_stays():
    env = begun(2, stack=2, randomise={"radio.max_range": (0.1, 0.2)})
    twin = copy.deepcopy(env)
    *given, infos = env.step(np.zeros((2, 4, 2)))
    for array in (*given, *infos.values()):
        array[...] = 1
    twin.step(np.zeros((2, 4, 2)))
    assert_same(run(env, 5), run(twin, 5))
    assert all((array == 1).all() for array in (*given, *infos.values()))


def test_threads_change_nothing(monkeypatch):
    monkeypatch.setattr(worlds_on_cpu, "ROBOTS_FOR_THREADS", 0)
    one, three = (run(begun(5, threads=n, shaping=1.0, stack=2), 9) for n in (1, 3))
    assert_same(one, three)


@pytest.mark.parametrize("learners", [0, 5, True, "epuck_9", ["epuck_0", 9], [], 1.5])
def test_learners_that_are_none_are_refused(learners):
    with pytest.raises((ConfigError, UnknownNameError), match=r"learners|no robot named"):
        ArrayEnv("es1", 1, learners=learners, **SHORT)


def test_those_who_do_not_learn_keep_their_layer():
    some = begun(1, learners=[np.int64(2)], controller="ssgiff")
    assert_array_equal(some.world.robots["action"]["motion"][0] != 0, [False, False, True, False])
    few = parallel_env("es1", learners=np.int64(2), **SHORT)
    assert list(few.reset(seed=0)[0]) == few.possible_agents == ["epuck_0", "epuck_1"]


@pytest.fixture
def exchanges(busy):
    return ArrayEnv(
        busy, 3, learn="weighting", step_on="exchange", physics="kinematic", max_cycles=600
    )


def test_a_step_ends_with_an_exchange_in_every_world_for_itself(exchanges):
    exchanges.reset(seed=0)
    ticks, acted = [], 0
    valid = exchanges.observation_layout.names.index("encounter.valid")
    for _ in range(15):
        seen, *_, truncated, infos = exchanges.step(np.zeros((3, 10, 2), np.float32))
        assert_array_equal(seen[..., valid], infos["acts"])
        assert ((infos["acts"].sum(axis=1) > 0) | truncated).all()
        ticks.append(exchanges.world.worlds["ticks"].copy())
        acted += infos["acts"].sum()
        if truncated.any():
            break
    assert acted > 20
    assert len(np.unique(ticks[-1])) == 3


def test_half_weights_from_exchange_to_exchange_are_half_weights_in_every_tick(busy):
    options = {"learn": "weighting", "physics": "kinematic", "max_cycles": 3000}
    slow = ArrayEnv(busy, 1, decision_period=1, **options)
    quick = ArrayEnv(busy, 1, step_on="exchange", **options)
    half = np.zeros((1, 10, 2), np.float32)
    slow.reset(seed=0)
    quick.reset(seed=0)
    total_reward = sum(quick.step(half)[1].sum() for _ in range(40))
    for _ in range(int(quick.world.worlds["ticks"][0])):
        slow.step(half)
    assert_array_equal(quick.world.robots["pose"], slow.world.robots["pose"])
    assert total_reward == slow.world.robots["round_trips"].sum()


def test_robot_steps_are_the_ticks_of_all_learners_however_long_a_step_takes(exchanges):
    held = begun(2, learners=3, decision_period=7)
    for _ in range(2):
        held.step(np.zeros((2, 3, 2), np.float32))
    assert held.robot_steps == 2 * 7 * 2 * 3
    ticks = 0
    for steps in (5, 1):
        exchanges.reset(seed=steps)
        for _ in range(steps):
            exchanges.step(np.zeros((3, 10, 2), np.float32))
        ticks += exchanges.world.worlds["ticks"].sum()
    assert exchanges.robot_steps == 10 * ticks > 10 * 3 * 6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"learn": "motion"}, "needs learn='weighting'"),
        ({"decision_period": 5}, "excludes decision_period"),
        ({"reward": lambda before, after, events: events["trip"]}, "needs reward='own' or 'team'"),
        ({"controller": OUTSIDE}, "whose layers are compiled"),
    ],
)
def test_steps_that_cannot_end_with_an_exchange_are_refused(options, message):
    with pytest.raises(ConfigError, match=message):
        ArrayEnv("es1", 1, **{"learn": "weighting", "step_on": "exchange", **options})


def test_an_environment_says_what_it_is():
    batch = ArrayEnv("near", n_worlds=3, learners=2, learn="weighting")
    description = "near: learn='weighting', controller='ssgikf', 3 worlds, 2 of 5 robots learn"
    assert repr(batch) == f"<ArrayEnv {description}, physics='rigid'>"
    one = "controller='ssgiff:weighting=sgikf,estimator.pause=2.0', 1 world, 5 of 5 robots learn"
    assert one in repr(parallel_env("near", controller="ssgiff:weighting=sgikf,pause=2"))
    assert "LearnerVectorEnv near" in repr(gymnasium.make_vec("SwarmForage/Near-v2", 3))
    assert "JointEnv near" in repr(gymnasium.make("SwarmForage/Near-Joint-v2").unwrapped)
