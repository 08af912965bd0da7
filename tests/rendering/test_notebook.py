"""Notebooks show environments, layouts and frames as pictures and tables."""

import base64
import io
import re
import sys

import gymnasium as gym
import numpy as np
import pytest
from numpy.testing import assert_array_equal
from PIL import Image

import swarm_forage_env  # noqa: F401 enters the ids
from swarm_forage_env import parallel_env
from swarm_forage_env.envs.array_env import ArrayEnv

few = {"max_cycles": 3, "physics": "kinematic"}


def pictures(page):
    """The pictures in some HTML, as arrays."""
    found = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    return [
        np.asarray(Image.open(io.BytesIO(base64.b64decode(each))).convert("RGB")) for each in found
    ]


def test_a_frame_shows_itself_and_is_an_array():
    env = parallel_env(render_mode="rgb_array", **few)
    env.reset(seed=1)
    frame = env.render()
    (picture,) = pictures(frame._repr_html_())
    assert_array_equal(picture, np.asarray(frame))
    assert isinstance(frame, np.ndarray)
    assert frame[0]._repr_html_() is None
    assert (frame / 2)._repr_html_() is None


def test_an_environment_shows_its_moment_and_its_numbers():
    env = parallel_env("es1", learn="both", controller="ssgiff", **few)
    before = env._repr_html_()
    assert pictures(before) == []
    for words in ("parallel_env", "es1 (foraging), ssgiff, policy for both", "10 of which learn"):
        assert words in before
    env.reset(seed=1)
    (picture,) = pictures(env._repr_html_())
    shown = parallel_env("es1", learn="both", controller="ssgiff", render_mode="rgb_array", **few)
    shown.reset(seed=1)
    assert_array_equal(picture, np.asarray(shown.render()))
    untouched = parallel_env("es1", learn="both", controller="ssgiff", **few)
    untouched.reset(seed=1)
    assert_array_equal(env.state(), untouched.state())


@pytest.mark.parametrize(
    ("make", "controller"),
    [
        (lambda: gym.make("SwarmForage/ES1-v2", **few).unwrapped, "ssgikf"),
        (lambda: gym.make_vec("SwarmForage/ES1-v2", num_envs=3, **few), "ssgikf"),
        (lambda: ArrayEnv("es1", n_worlds=3, controller=["nc"] * 5 + ["ssgikf"] * 5, **few),
         "nc, ssgikf"),
        (lambda: ArrayEnv("waypoints-05", max_cycles=3), "boids-adaptive"),
    ],
    ids=["gymnasium", "vector", "arrays", "waypoints"],
)  # fmt: skip
def test_every_environment_shows_itself_and_names_the_controller_that_runs(make, controller):
    env = make()
    env.reset(seed=1)
    page = env._repr_html_()
    assert len(pictures(page)) == 1
    assert f"{controller}, policy for motion" in page


def test_without_pygame_the_numbers_remain(monkeypatch):
    env = parallel_env(**few)
    env.reset(seed=1)
    monkeypatch.setitem(sys.modules, "pygame", None)
    monkeypatch.setattr("swarm_forage_env.envs.notebook.find_spec", lambda name: None)
    page = env._repr_html_()
    assert pictures(page) == []
    assert "situation.target.x" in page


def test_a_layout_is_a_table_with_a_row_for_each_number():
    layout = parallel_env(**few).observation_layout
    page = layout._repr_html_()
    assert page.count("<tr>") == len(layout) + 1
    assert all(f"<td>{slot.name}</td>" in page for slot in layout)
