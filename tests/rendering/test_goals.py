"""Robots that visit goals: a picture shows goals, claims, what filters believe, and lidar."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.layout import Layout
from swarm_forage_env.rendering.painter import Show
from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.trails import TRAIL, Trails
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.scene import TALKING, WITHIN, Localised
from swarm_forage_env.task import stage_of
from swarm_forage_env.waypoints.drawing import ellipses
from tests.rendering.replay.pages import unpacked
from tests.rendering.scenes import scene_of, scenes_of
from tests.rendering.test_painter import near, painted

STAGE = stage_of(find_scenario("waypoints-05"), "boids-adaptive")
BARE = Show(trails=False, messages=False)


@pytest.fixture(scope="module")
def loop():
    """Two worlds of five robots after 40 s."""
    found = Loop(find_scenario("waypoints-05"), find_controller("boids-goal"), [1, 2])
    found.run(80)
    return found


def scene(time=60.0, n=1, **changes):
    """Robots at the origin that go to (3, 2) and believe they are at (-2, 1)."""
    own = {
        "goal": np.tile([3.0, 2.0], (n, 1)),
        "believed": np.tile([-2.0, 1.0], (n, 1)),
        "ellipse": np.tile([0.5, 0.25, math.pi / 2], (n, 1)),
        "right": np.zeros(n, np.int32),
        "wrong": np.zeros(n, np.int32),
    }
    pose = changes.pop("pose", np.zeros((n, 3)))
    messages = changes.pop("messages", np.zeros((0, 2), np.int32))
    own |= changes
    return scene_of(pose, time=time, localised=Localised(**own), messages=messages)


def shown(*scenes, show=BARE):
    return painted(*scenes, stage=STAGE, width=720, show=show)[1]


def test_a_scene_is_the_truth_about_its_own_world(loop):
    for which in range(2):
        found, robots = loop.scene(which), loop.world.robots[which]
        belief = loop.controller.minds["estimator"]["belief"][which]
        assert found.time == 40.0
        assert_array_equal(found.pose, robots["pose"])
        assert_array_equal(found.localised.goal, robots["goal"])
        assert_array_equal(found.localised.believed, belief["pose"][:, :2])
        assert found.total == robots["right"].sum()
        seen = loop.world.sightings["seen"][which]
        assert_array_equal(found.messages[:, ::-1], np.argwhere(seen))
        assert_array_equal(found.activity == TALKING, seen.any(axis=1))
        within = found.localised.is_within(found.pose)
        for robot in range(5):
            away = belief["pose"][robot, :2] - robots["pose"][robot, :2]
            squared = away @ np.linalg.inv(belief["P"][robot, :2, :2]) @ away
            assert within[robot] == (squared <= -2.0 * math.log(0.05))
    assert (loop.scene(0).localised.goal != loop.scene(1).localised.goal).any()


def test_an_ellipse_has_the_axes_of_its_covariance():
    roots = np.random.default_rng(1).normal(size=(20, 2, 2))
    covariance = roots @ roots.transpose(0, 2, 1)
    long, short, direction = ellipses(covariance).T
    values, vectors = np.linalg.eigh(covariance)
    assert_allclose(np.stack([short, long], axis=1), np.sqrt(values), rtol=1e-9)
    along = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    assert_allclose(np.abs((along * vectors[:, :, 1]).sum(axis=1)), 1.0, rtol=1e-9)


def test_a_goal_is_a_ring_as_large_as_it_is_reached():
    at = shown(scene(), show=Show(trails=False, messages=False, beliefs=False))
    tolerance = STAGE.goals.tolerance
    rim = [at(3.0 + tolerance - inside, 2.0) for inside in (0.0, 0.01, 0.02, 0.03)]
    assert any(colour == near(palette.GOAL, 60) for colour in rim)
    assert at(3.0 + 0.55 * tolerance, 2.0) == near(palette.FLOOR, 12)
    assert at(-2.0, 1.0) == near(palette.FLOOR)


def test_an_estimate_is_an_ellipse_and_a_line_to_the_truth():
    at = shown(scene())
    for place in ((-2.0, 1.0 + 0.5 * WITHIN), (-2.0 - 0.25 * WITHIN, 1.0), (-1.0, 0.5)):
        assert at(*place) == near(palette.ESTIMATE, 60)
    assert at(-2.0 - 0.5 * WITHIN, 1.0) == near(palette.FLOOR)
    nothing = shown(scene(ellipse=np.zeros((1, 3)), believed=np.zeros((1, 2))))
    assert nothing(-2.0, 1.0 + 0.5 * WITHIN) == near(palette.FLOOR)


def test_claims_are_marked_where_they_were_made_for_as_long_as_trails_last():
    before = scene(60.0, pose=np.array([[3.1, 2.0, 0.0], [-3.0, -3.0, 0.0]]), n=2)
    goal = np.array([[0.5, -4.0], [0.5, -4.0]])
    own = {"right": np.array([1, 0], np.int32), "wrong": np.array([0, 1], np.int32)}
    after = scene(60.5, n=2, goal=goal, **own)
    trails = Trails()
    for each in (before, after):
        trails.take(each)
    right, wrong = trails.claims
    assert (right.is_right, wrong.is_right) == (True, False)
    assert_array_equal(right.goal, [3.0, 2.0])
    assert_array_equal(wrong.place, [-3.0, -3.0])
    at = shown(before, after)
    shift = 3.3 / Layout(STAGE, 720).scale * 1.4
    assert at(3.1 - shift, 2.0) == near(palette.RIGHT, 40)
    assert at(-3.0, -3.0) == near(palette.WRONG, 40)
    assert at(0.0, -0.5) == near(palette.WRONG, 90), "the line from the claim to the goal"
    trails.take(replace(after, time=60.5 + TRAIL + 0.5))
    assert not trails.claims


def test_lidar_is_a_circle_and_a_line_between_those_that_see_each_other():
    pose = np.array([[-2.0, -2.0, 0.0], [-1.4, -2.0, 0.0]])
    pairs = np.array([[0, 1], [1, 0]], np.int32)
    picture = scene(n=2, pose=pose, messages=pairs)
    quiet = Show(trails=False, beliefs=False)
    at = shown(picture, show=quiet)
    assert at(-1.7, -2.0) == near(palette.MESSAGE, 60)
    around = [at(-2.0 - STAGE.goals.reach + d, -2.0) for d in np.linspace(-0.05, 0.05, 9)]
    assert any(colour != near(palette.FLOOR, 12) for colour in around)
    hidden = shown(picture, show=Show(trails=False, messages=False, beliefs=False))
    assert hidden(-1.7, -2.0) == near(palette.FLOOR, 12)


def test_a_recording_holds_goals_claims_and_ellipses_within_its_rounding(loop):
    fresh = Loop(find_scenario("waypoints-05"), find_controller("boids-adaptive"), [3])
    scenes, recording = scenes_of(fresh, 59), Recording()
    for each in scenes:
        recording.add(each)
    _, share, _, columns = unpacked(*recording.pack())
    assert_allclose(share, [each.share for each in scenes], atol=1e-6)
    own = [each.localised for each in scenes]
    for name, atol, take in (
        ("goalX", 6e-4, lambda each: each.goal[:, 0]),
        ("believedY", 1.1e-3, lambda each: each.believed[:, 1]),
        ("long", 2.6e-3, lambda each: each.ellipse[:, 0]),
        ("right", 0.0, lambda each: each.right),
        ("wrong", 0.0, lambda each: each.wrong),
    ):
        assert_allclose(columns[name], np.stack([take(each) for each in own], axis=1), atol=atol)
    assert "known" not in columns
