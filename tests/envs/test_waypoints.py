"""The environment of the waypoints world: spaces, cuts, rewards, infos and refusals.

The proof of the cuts is that of foraging: the baseline's own rule, driven from outside through
`env.step` from the observation alone, reproduces the built-in run bit for bit.
"""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from pettingzoo.test import parallel_api_test, parallel_seed_test

from baselines.controller import LayeredController
from baselines.estimators import ESTIMATORS as ESTIMATOR_PARTS
from baselines.motion.boids import BoidsParameters
from baselines.weighting.filter import Filter
from swarm_forage_env import ConfigError, UnknownNameError
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.policies import LEARNABLE
from swarm_forage_env.waypoints.records import WORDS
from tests.commands import parallel_env
from tests.outside import OutsideMotion, motion_inputs, weigh

SEED, TICKS = 7, 150
INFOS = {"goals", "false_goals", "position_error_m"}
ESTIMATORS = ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
SETTINGS = ("authors", "corrected")
GAINS = ("goal", "static", "adaptive")

every_layer = pytest.mark.parametrize("learn", list(LEARNABLE))


@every_layer
def test_pettingzoo_accepts_agents_in_parallel(learn):
    parallel_api_test(parallel_env("waypoints-05", learn=learn), num_cycles=250)


@every_layer
def test_pettingzoo_finds_one_seed_one_episode(learn):
    parallel_seed_test(lambda: parallel_env("waypoints-05", learn=learn), num_cycles=50)


def assert_stays_inside(env, sampler):
    observations, _ = env.reset(seed=SEED)
    act = sampler(env, SEED)
    for _ in range(300):
        for agent, observation in observations.items():
            assert env.observation_space(agent).contains(observation)
        assert env.state_space.contains(env.state())
        observations, *_ = env.step(act())
    assert env.agents == []


@every_layer
@pytest.mark.parametrize("scenario", ["waypoints-10", "waypoints-25-authors"])
def test_whatever_robots_do_what_they_observe_is_inside_the_space(learn, scenario, sampler):
    assert_stays_inside(parallel_env(scenario, learn=learn, max_cycles=300), sampler)


@pytest.mark.parametrize(("estimator", "setting"), list(product(ESTIMATORS, SETTINGS)))
def test_whatever_is_believed_is_inside_the_space(estimator, setting, sampler):
    controller = f"boids-adaptive:estimator={estimator},setting={setting}"
    env = parallel_env("waypoints-10", learn="both", controller=controller, max_cycles=300)
    assert_stays_inside(env, sampler)


def assert_same_run(learn, recipe, decide):
    """Drive one layer by `decide(records shown)`; how many corrections there were."""
    scenario = find_scenario("waypoints-10")
    loop = Loop(scenario, recipe, [SEED])
    env = parallel_env(scenario, learn=learn, controller=recipe)
    observations, _ = env.reset(seed=SEED)
    corrections = 0
    for tick in range(TICKS):
        matrix = np.stack(list(observations.values()))
        actions = decide(env.observation_layout.records(matrix))
        observations, *_ = env.step(dict(zip(env.agents, actions, strict=True)))
        loop.step()
        corrections += np.count_nonzero(loop.exchange.is_valid)
        assert (env.world.state.pose == loop.world.state.pose).all(), f"they part at tick {tick}"
    ours, theirs = env.array_env.loop.controller, loop.controller
    for name in ("belief", "reckoned"):
        assert_array_equal(ours.minds["estimator"][name], theirs.minds["estimator"][name], name)
    assert_array_equal(ours.shared, theirs.shared, "factors")
    for name in set(loop.world.robots.dtype.names) - {"action"}:
        assert_array_equal(env.world.robots[name], loop.world.robots[name], name)
    return corrections


def inside(gains, estimator, setting):
    localisation = ESTIMATOR_PARTS[estimator](setting=setting)
    return LayeredController("inside", localisation, Filter(), BoidsParameters(gains=gains))


def motion_of(recipe):
    scenario = find_scenario("waypoints-10")
    motion = OutsideMotion(recipe.motion.layer(scenario), scenario, [SEED])
    return lambda seen: motion(*motion_inputs(seen, "acceleration"))


def weighting_of(recipe):
    own = recipe.estimator.layer(find_scenario("waypoints-10")).own_weighting
    return lambda seen: weigh(own, seen["exchange"])


every_recipe = pytest.mark.parametrize(
    ("gains", "estimator", "setting"), list(product(GAINS, ESTIMATORS[1:], SETTINGS))
)


@every_recipe
def test_boids_from_outside_are_the_boids_inside(gains, estimator, setting):
    recipe = inside(gains, estimator, setting)
    assert assert_same_run("motion", recipe, motion_of(recipe)) > 30


@pytest.mark.parametrize(("estimator", "setting"), list(product(ESTIMATORS, SETTINGS)))
def test_both_layers_from_outside_are_those_inside(estimator, setting):
    recipe = inside("adaptive", estimator, setting)
    rule = weighting_of(recipe)
    motion = motion_of(recipe)

    def decide(seen):
        return np.concatenate([rule(seen), motion(seen)], axis=1)

    assert assert_same_run("both", recipe, decide) > 30


def test_no_weight_is_another_run_than_the_full_one():
    recipe = inside("adaptive", "decentralised_ekf", "corrected")
    with pytest.raises(AssertionError, match="they part at tick"):
        assert_same_run("weighting", recipe, lambda seen: np.zeros((10, 1), np.float32))


def full(env):
    return dict.fromkeys(env.agents, np.ones(1, np.float32))


@every_layer
def test_infos_have_the_same_numbers_from_the_reset_on(learn, sampler):
    env = parallel_env("waypoints-05", learn=learn)
    _, infos = env.reset(seed=SEED)
    act = sampler(env, SEED)
    for _ in range(30):
        assert list(infos) == env.possible_agents
        for log in infos.values():
            assert set(log) == INFOS | {"unshaped_reward"}
            assert all(isinstance(number, float | int) for number in log.values())
            assert np.isfinite(list(log.values())).all()
        *_, infos = env.step(act())


def test_infos_count_claims_and_measure_the_belief_against_the_truth():
    env = parallel_env("waypoints-05", learn="weighting")
    env.reset(seed=SEED)
    while env.agents:
        *_, infos = env.step(full(env))
    logs, state = list(infos.values()), env.world.state
    believed = rows(env.array_env.loop.controller.minds["estimator"]["belief"]).pose
    assert [log["goals"] for log in logs] == state.right.tolist()
    assert [log["false_goals"] for log in logs] == state.wrong.tolist()
    assert state.right.sum() > 0
    off = np.linalg.norm(believed[:, :2] - state.pose[:, :2], axis=1)
    np.testing.assert_allclose([log["position_error_m"] for log in logs], off)


def test_a_learner_of_everything_is_heard_by_those_who_see_it():
    env = parallel_env("waypoints-05", learn="everything", **{"task.start_half_side": 0.2})
    env.reset(seed=SEED)
    said = np.linspace(-1.0, 1.0, WORDS, dtype=np.float32)
    actions = {
        agent: np.array([0.0, 0.0, -1.0, *(said * (k + 1) / 5.0)], np.float32)
        for k, agent in enumerate(env.agents)
    }
    observations, *_ = env.step(actions)
    seen = env.world.sightings["seen"][0]
    assert seen.any()
    names = env.observation_layout.names
    start = names.index("heard.words.0.0")
    for i, observation in enumerate(observations.values()):
        words = observation[start : start + 5 * WORDS].reshape(5, WORDS)
        for j in range(5):
            expected = actions[f"create_{j}"][3:] if seen[i, j] else np.zeros(WORDS)
            assert_array_equal(words[j], expected)
    observations, _ = env.reset(seed=SEED)
    for observation in observations.values():
        assert not observation[start : start + 5 * WORDS].any()


def test_the_state_holds_the_truth_and_the_beliefs():
    env = parallel_env("waypoints-05", learn="motion")
    env.reset(seed=SEED)
    for _ in range(10):
        env.step(dict.fromkeys(env.agents, np.array([0.3, 0.4], np.float32)))
    state = dict(zip(env.state_layout.names, env.state(), strict=True))
    believed = rows(env.array_env.loop.controller.minds["estimator"]["belief"]).pose
    for k, agent in enumerate(env.possible_agents):
        x, y, theta = env.world.state.pose[k]
        named = {
            "pose.x": x, "pose.y": y, "heading.cos": np.cos(theta), "heading.sin": np.sin(theta),
            "goal.x": env.world.state.goal[k, 0], "goal.y": env.world.state.goal[k, 1],
            "believed.x": believed[k, 0], "believed.y": believed[k, 1],
        }  # fmt: skip
        for name, value in named.items():
            assert state[f"{agent}.{name}"] == pytest.approx(value, rel=1e-6), name
    assert state["share_gone"] == pytest.approx(10 / 200)


@pytest.mark.parametrize("controller", ["ssgikf", "nc", "ssgiff:beta=0.1"])
@pytest.mark.parametrize("learn", ["motion", "weighting", "both"])
def test_a_controller_of_foragers_is_refused_by_name(controller, learn):
    name = controller.partition(":")[0]
    with pytest.raises(ConfigError, match=f"controller '{name}' does not run on 'waypoints-05'"):
        parallel_env("waypoints-05", controller=controller, learn=learn)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"task.n_robot": 3}, "named 'task.n_robot', did you mean 'task.n_robots'"),
        ({"toleranc": 0.1}, "named 'toleranc', did you mean"),
        ({"radio.max_range": 0.2}, "named 'radio.max_range'"),
        ({"controller": "boids-static:gain=goal"}, "no parameter of boids-static named 'gain'"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(options, says):
    with pytest.raises(UnknownNameError, match=says):
        parallel_env("waypoints-05", **options)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"physics": "rigid"}, "physics='rigid'"),
        ({"task.tolerance": -0.1}, "task.tolerance=-0.1"),
        ({"min_speed": 0.6}, "must be below max_speed=0.5"),
        ({"first_goal": 5.0}, "must be below half of side=10"),
        ({"duration": 0.1}, "must be at least one tick"),
        ({"controller": "boids-static:setting=best"}, "setting="),
        (
            {"controller": "boids-static:estimator=social_odometry"},
            "its estimator is not made for the task waypoints",
        ),
    ],
)
def test_a_value_that_cannot_be_used_is_refused(options, says):
    with pytest.raises(ConfigError, match=says):
        parallel_env("waypoints-05", **options)
