"""The environment of waypoints: spaces, cuts (proven as for foraging), infos and state."""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.controller import LayeredController
from baselines.estimators import ESTIMATORS as ESTIMATOR_PARTS
from baselines.motion.boids import BoidsParameters
from baselines.weighting.filter import Filter
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.policies import LEARNABLE
from swarm_forage_env.waypoints.records import WORDS
from tests.commands import parallel_env
from tests.envs.test_layers import assert_same_run
from tests.outside import OutsideMotion, motion_inputs, weigh

SEED, SCENARIO = 7, find_scenario("waypoints-10")
ESTIMATORS = ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
SETTINGS = ("authors", "corrected")
GAINS = ("goal", "static", "adaptive")


BELIEVED = [
    f"boids-adaptive:estimator={estimator},setting={setting}"
    for estimator, setting in product(ESTIMATORS, SETTINGS)
]


@pytest.mark.parametrize(
    ("scenario", "learn", "controller"),
    [
        *product(("waypoints-10", "waypoints-05-authors"), LEARNABLE, [None]),
        *product(["waypoints-10"], ["both"], BELIEVED),
    ],
)
def test_what_is_observed_and_believed_is_inside_the_space(scenario, learn, controller, sampler):
    env = parallel_env(scenario, learn=learn, controller=controller, max_cycles=150)
    observations, _ = env.reset(seed=SEED)
    act = sampler(env, SEED)
    for _ in range(150):
        for agent, observation in observations.items():
            assert env.observation_space(agent).contains(observation)
        assert env.state_space.contains(env.state())
        observations, *_ = env.step(act())


def corrections(learn, recipe, decide):
    """How many there were in the same run under `decide(records shown)`."""
    return assert_same_run(learn, SCENARIO, recipe, decide, ticks=150)[1]


def inside(gains, estimator, setting):
    localisation = ESTIMATOR_PARTS[estimator](setting=setting)
    return LayeredController("inside", localisation, Filter(), BoidsParameters(gains=gains))


def motion_of(recipe):
    motion = OutsideMotion(recipe.motion.layer(SCENARIO), SCENARIO, [SEED])
    return lambda seen: motion(*motion_inputs(seen, "acceleration"))


def weighting_of(recipe):
    own = recipe.estimator.layer(SCENARIO).own_weighting
    return lambda seen: weigh(own, seen["exchange"])


@pytest.mark.parametrize(
    ("learn", "gains", "estimator", "setting"),
    [
        *product(["motion"], GAINS, ESTIMATORS[2:], SETTINGS[1:]),
        *product(["both"], ["adaptive"], ESTIMATORS, SETTINGS),
    ],
)
def test_layers_from_outside_are_those_inside(learn, gains, estimator, setting):
    recipe = inside(gains, estimator, setting)
    rule, motion = weighting_of(recipe), motion_of(recipe)

    def decide(seen):
        weights = [rule(seen)] if learn == "both" else []
        return np.concatenate([*weights, motion(seen)], axis=1)

    assert corrections(learn, recipe, decide) > 30


def test_no_weight_is_another_run_than_the_full_one():
    recipe = inside("adaptive", "decentralised_ekf", "corrected")
    with pytest.raises(AssertionError, match="they part at tick"):
        corrections("weighting", recipe, lambda seen: np.zeros((10, 1), np.float32))


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
