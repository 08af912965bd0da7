"""Rewards: round trips, shared or not, and the potential that may shape them."""

import math

import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from swarm_forage_env import ArrayEnv, ConfigError
from swarm_forage_env.epuck.parts import Arena
from swarm_forage_env.foraging.rewards import potential
from swarm_forage_env.foraging.scenario import Scenario, Task
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.scenarios import find_scenario
from tests.commands import parallel_env

STEPS = 1500

SCENARIO = Scenario(arena=Arena(length=1.7, width=1.2), task=Task(area_distance=0.8, n_robots=1))
"""Nest at (-0.4, 0), prey at (0.4, 0)."""


def rewards_of(scenario, constant, **options):
    """What a hand-written swarm earns, (steps, robots), and the environment afterwards."""
    env = parallel_env(scenario, learn="weighting", **options)
    env.reset(seed=1)
    half = constant(env, 0.5, 0.5)
    steps = STEPS // options.get("decision_period", 1)
    return np.array([list(env.step(half)[1].values()) for _ in range(steps)]), env


def test_a_team_is_the_robots_of_one_world(busy):
    def run(reward):
        env = ArrayEnv(busy, 3, learn="weighting", reward=reward, decision_period=10)
        env.reset(seed=1)
        half = np.full((3, 10, *env.action_shape), 0.5, np.float32)
        return np.array([env.step(half)[1] for _ in range(STEPS // 10)])

    own, team = run("own"), run("team")
    assert len({each.tobytes() for each in np.moveaxis(own, 1, 0)}) == 3, "the worlds differ"
    assert (own.sum(axis=(0, 2)) > 0).all()
    np.testing.assert_allclose(team, np.broadcast_to(own.mean(axis=2, keepdims=True), own.shape))


@pytest.mark.parametrize("reward", ["own", "team"])
@pytest.mark.parametrize("period", [1, 5])
def test_the_discounted_shaping_of_an_episode_depends_on_its_ends_only(
    busy, constant, reward, period
):
    """sum_t d^t w (d Phi_t+1 - Phi_t) = w (d^T Phi_T - Phi_0)."""
    discount, weight = 0.97, 1.25
    options = {"reward": reward, "decision_period": period}
    plain, _ = rewards_of(busy, constant, **options)
    shaped, again = rewards_of(busy, constant, shaping=weight, discount=discount, **options)
    powers = discount ** np.arange(len(plain))
    added = ((shaped - plain) * powers[:, None]).sum(axis=0)
    last = potentials(again.world)
    again.reset(seed=1)
    first = potentials(again.world)
    expected = weight * (discount ** len(plain) * last - first)
    expected = np.full(10, expected.mean()) if reward == "team" else expected
    np.testing.assert_allclose(added, expected, atol=1e-9)
    assert np.abs(shaped - plain).max() > 0.0


def potentials(world):
    return np.array([potential(robot, world.worlds[0]) for robot in world.robots[0]])


@pytest.mark.parametrize(
    ("leg", "x", "y", "share"),
    [
        (0, 0.85, 0.6, 0.0),  # the corner farthest from the nest
        (0, -0.4, 0.0, 1 / 3),
        (1, -0.85, 0.6, 1 / 3),
        (1, 0.4, 0.0, 2 / 3),
        (2, 0.0, 0.0, 1.0 - 0.4 / math.hypot(1.25, 0.6) / 3),
        (2, -0.4, 0.0, 1.0),
    ],
)
def test_the_potential_rises_along_the_trip(leg, x, y, share):
    world = ForagingWorld([find_scenario("two-prey", {"n_robots": 1})], [0], "kinematic")
    world.replace_scenarios([0], [SCENARIO])  # of fewer areas
    world.reset([0])
    world.robots["leg"], world.robots["pose"] = leg, (x, y, 0.0)
    assert potentials(world) == pytest.approx([share])


def test_the_events_of_a_tick_are_what_happened(busy):
    seen = []

    def watch(before, after, events):
        seen.append((before.copy(), after.copy(), events.copy()))
        return events["trip"] - 0.1 * events["contact"]

    env = ArrayEnv(busy, 1, learn="weighting", reward=watch, physics="kinematic", shaping=0.5)
    env.reset(seed=0)
    for tick in range(2500):
        *_, infos = env.step(np.zeros((1, 10, 2), np.float32))
        paid = seen[tick][2]["trip"] - 0.1 * seen[tick][2]["contact"]
        np.testing.assert_allclose(infos["unshaped_reward"], paid)
    assert all(sum(events[name].sum() for *_, events in seen) for name in ("trip", "contact"))
    for before, after, events in seen:
        np.testing.assert_array_equal(events["trip"], after["round_trips"] > before["round_trips"])
        np.testing.assert_array_equal(events["message"], after["messages"] - before["messages"])
        first = (after["first_visit"] >= 0) & (before["first_visit"] < 0)
        assert (events["visit"][first[..., 0]] == 0).all()
        assert (events["visit"][first[..., 1]] * 100 * 2 == 200).all()
    losses = sum(int(events["loss"].sum()) for *_, events in seen)
    counted = int(seen[-1][1]["lost_events"].sum())
    assert counted <= losses <= counted + 10
    pose = seen[-1][1]["pose"][0, :, :2]
    apart = np.linalg.norm(pose[:, None] - pose[None], axis=2) + np.eye(10)
    wall = (np.abs(pose) >= np.array([0.85, 0.6]) - 0.035 - 1e-3).any(axis=1)
    np.testing.assert_array_equal(
        seen[-1][2]["contact"][0], (apart <= 0.07 + 1e-3).any(axis=1) | wall
    )


@pytest.mark.parametrize(
    ("reward", "message"),
    [
        (7, "reward=7: must be 'own', 'team', or callable"),
        (lambda *_: np.zeros(3), r"gave shape \(3,\), must be \(1, 10\)"),
        (lambda *_: "much", "gave 'much', must be numbers"),
        (lambda before, after, events: events["trip"] * np.nan, "gave nan to robot 0 of world 0"),
        (lambda before, after, events: after["pose"].__isub__(before["pose"]), "read-only"),
    ],
)
def test_a_reward_that_is_none_is_refused(reward, message):
    still = np.zeros((1, 10, 2), np.float32)
    with pytest.raises(ValueError, match=message):  # noqa: PT012 some are refused when it is made
        env = ArrayEnv("es1", 1, reward=reward)
        env.reset(seed=0)
        env.step(still)
    if callable(reward):
        with pytest.raises(ResetNeeded, match="interrupted by an exception: call reset"):
            env.step(still)


def with_worths(scenario, nest, prey):
    """The scenario with what its nest and its prey area are worth."""
    half = 0.5 * scenario.task.area_distance
    areas = ("nest", -half, nest), ("prey", half, prey)
    areas = [{"kind": kind, "centre": [x, 0.0], "worth": worth} for kind, x, worth in areas]
    return find_scenario(scenario, {"task.areas": areas})


def test_under_the_largest_weight_a_trip_of_little_worth_costs_nothing_in_its_tick(busy, constant):
    poor = with_worths(busy, 0.25, 2.0)
    plain, _ = rewards_of(poor, constant)
    shaped, _ = rewards_of(poor, constant, shaping=0.75)
    paid = shaped[plain > 0.0]
    assert set(np.unique(plain)) == {0.0, 0.5}
    assert 0.0 <= paid.min() < paid.max() < 0.5
    # the potential falls by two thirds at most, and a weight of 1.5 would take as much as it pays
    assert (plain + 2.0 * (shaped - plain))[plain > 0.0].min() < 0.0


@pytest.mark.parametrize(
    ("scenario", "worth", "most"),
    [
        (SCENARIO, 1.0, 1.5),
        (with_worths(SCENARIO, 0.5, 1.0), 0.5, 0.75),
        (with_worths(SCENARIO, 0.25, 2.0), 0.5, 0.75),
        (with_worths(SCENARIO, 2.0, 3.0), 6.0, 9.0),
    ],
)
def test_the_largest_weight_goes_by_the_trip_that_is_worth_least(scenario, worth, most):
    ArrayEnv(scenario, 1, shaping=most)
    with pytest.raises(ConfigError, match=rf"pays {worth:g} - 2 w / 3 .* at most {most:g}"):
        ArrayEnv(scenario, 1, shaping=1.01 * most)
