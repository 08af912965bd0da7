"""The render modes of the environment, and the tools of PettingZoo that use them."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.testing import assert_array_equal
from pettingzoo.test import render_test

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.policies import LEARNABLE
from swarm_forage_env.rendering import palette, viewer
from swarm_forage_env.rendering.layout import Layout
from swarm_forage_env.rendering.viewer import FRAME_WIDTH
from swarm_forage_env.task import stage_of
from tests.commands import env, parallel_env
from tests.scripts import run_python

few = {"task.n_robots": 4, "task.duration": 3.0}


def still(made):
    """An action of zeros for everybody."""
    return {agent: np.zeros(made.action_space(agent).shape, np.float32) for agent in made.agents}


def test_pettingzoo_accepts_both_render_modes():
    assert env(**few).metadata["render_modes"] == ["human", "rgb_array", "ansi"]
    render_test(lambda **mode: env(**few, **mode))


def test_where_pygame_is_missing_a_map_is_drawn_and_a_frame_says_what_to_install(monkeypatch):
    monkeypatch.setattr(viewer, "find_spec", lambda name: None)
    with pytest.raises(ConfigError, match=r"needs 'pygame': pip install 'swarm-forage\[render\]'"):
        parallel_env(render_mode="rgb_array")
    made = gymnasium.make("SwarmForage/Near-v2").unwrapped
    assert made.metadata["render_modes"] == ["ansi"]
    check_env(made)


@pytest.mark.parametrize("learn", list(LEARNABLE))
def test_a_frame_is_an_array_of_colours_whatever_is_learned(learn):
    made = parallel_env("es1", learn=learn, render_mode="rgb_array", **few)
    made.reset(seed=1)
    first = made.render()
    assert first.dtype == np.uint8
    assert first.shape[1:] == (512, 3)
    made.step(still(made))
    second = made.render()
    assert second.shape == first.shape
    assert (first != second).any()
    assert np.unique(first.reshape(-1, 3), axis=0).shape[0] > 50
    made.close()


def test_a_frame_shows_the_robots_of_the_first_world_where_they_are_now():
    made = parallel_env("es1", render_mode="rgb_array", **few)
    made.reset(seed=1)
    layout = Layout(stage_of(made.scenario, "ssgikf"), FRAME_WIDTH)
    pose = made.world.robots["pose"][0]
    for here, there in ((0.4, -0.4), (-0.4, 0.4)):
        pose[:, 0], pose[:, 1] = (-0.3, -0.1, 0.1, 0.3), here
        frame = made.render()
        for x in pose[:, 0]:
            (column, row), (_, empty) = layout.in_picture(np.array([[x, here], [x, there]]))
            assert frame[int(empty), int(column)] == pytest.approx(palette.FLOOR, abs=6)
            assert frame[int(row), int(column)] != pytest.approx(palette.FLOOR, abs=6)


def test_frames_need_no_display(monkeypatch):
    def frame(seed):
        made = parallel_env(render_mode="rgb_array", **few)
        made.reset(seed=seed)
        return made.render()

    with_one, of_others = frame(1), frame(2)
    monkeypatch.setenv("SDL_VIDEODRIVER", "none-such")
    assert_array_equal(frame(1), with_one)
    assert (frame(1) != of_others).any()


def test_looking_changes_nothing():
    ends = []
    for mode in (None, "rgb_array"):
        made = parallel_env(render_mode=mode, **few)
        made.reset(seed=3)
        while made.agents:
            made.step(dict.fromkeys(made.agents, np.array([0.9, 0.4], np.float32)))
            if mode:
                made.render()
        ends.append(made.state())
    assert_array_equal(*ends)


def test_nothing_is_loaded_until_somebody_looks():
    code = "from swarm_forage_env import parallel_env; parallel_env().reset(seed=1)"
    assert run_python("-c", f"{code}; import sys; print('pygame' in sys.modules)") == "False"


def test_a_map_of_characters_shows_robots_and_areas_where_they_are():
    made = parallel_env("es1", render_mode="ansi", **few)
    made.reset(seed=1)
    *rows, legend = made.render().splitlines()
    assert {len(row) for row in rows} == {60}
    assert legend == "0.0 s, round trips 0, on path 0%"
    nest = {at for row in rows for at, sign in enumerate(row) if sign == "#"}
    prey = {at for row in rows for at, sign in enumerate(row) if sign == "%"}
    assert max(nest) < 10 < 50 < min(prey)
    pose = made.world.robots["pose"][0]
    for robot, (x, y, _) in enumerate(pose):
        column = int((x / made.scenario.arena.length + 0.5) * 60)
        row = int((0.5 - y / made.scenario.arena.width) * len(rows))
        assert rows[row][column] == str(robot)
    made.close()
