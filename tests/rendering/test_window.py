"""The live window: keys, pace, selection, on a display that is only in memory."""

import pygame
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering import window as windows
from swarm_forage_env.rendering.layout import Layout
from swarm_forage_env.rendering.window import Window
from swarm_forage_env.task import stage_of


class Clock:
    """A time that passes only while somebody sleeps."""

    def __init__(self):
        self.now, self.naps, self.while_asleep = 100.0, 0, {}

    def perf_counter(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds
        self.naps += 1
        for key in self.while_asleep.pop(self.naps, ()):
            press(key)


def press(key, kind=pygame.KEYDOWN):
    pygame.event.post(pygame.event.Event(kind, key=key))


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(windows, "time", found)
    return found


@pytest.fixture(scope="module")
def scenes(busy):
    loop = Loop(busy, find_controller("ssgikf"), [1])
    found = []
    for _ in range(60):
        found.append(loop.scene())
        loop.step()
    return found


@pytest.fixture
def window(busy, clock):
    found = Window(stage_of(busy, "ssgikf"), 480)
    yield found
    found.close()


@pytest.fixture
def drawn(window, monkeypatch):
    """The times of the scenes that were drawn, as they are."""
    times, draw = [], window._draw

    def noted():
        times.append(window._scene.time)
        draw()

    monkeypatch.setattr(window, "_draw", noted)
    return times


@pytest.mark.parametrize(("speed", "n_least", "n_most"), [(1.0, 60, 240), (10.0, 15, 20)])
def test_it_goes_at_its_speed_and_draws_no_more_than_it_must(
    window, scenes, clock, drawn, speed, n_least, n_most
):
    window.speed = speed
    for scene in scenes:
        window.show(scene)
    assert clock.now - 100.0 == pytest.approx(5.9 / speed, abs=0.04)
    assert n_least <= len(drawn) <= n_most


def test_keys_change_speed_and_what_is_shown(window, scenes):
    window.show(scenes[0])
    for key in (pygame.K_PLUS, pygame.K_PLUS, pygame.K_MINUS):
        press(key)
    for key in (pygame.K_t, pygame.K_b, pygame.K_m):
        press(key)
    window.show(scenes[1])
    show = window.show_what
    assert window.speed == 2.0
    assert (show.trails, show.beliefs, show.messages) == (False, False, False)


def test_space_pauses_and_a_step_shows_the_next_scene(window, scenes, clock, drawn):
    window.show(scenes[0])
    press(pygame.K_SPACE)
    clock.while_asleep = {6: [pygame.K_PERIOD], 12: [pygame.K_PERIOD], 20: [pygame.K_SPACE]}
    for scene in scenes[1:3]:
        window.show(scene)
        assert window.paused
    window.show(scenes[3])
    assert not window.paused
    assert set(drawn) == {scene.time for scene in scenes[:4]}
    assert clock.naps >= 20


def test_tab_and_click_select_a_robot(window, scenes, busy):
    window.show(scenes[0])
    press(pygame.K_TAB)
    press(pygame.K_TAB)
    window.show(scenes[1])
    assert window.show_what.selected == 1
    places = Layout(stage_of(busy, ""), 480).in_picture(scenes[2].pose[:, :2])
    click = {"button": 1, "pos": tuple(places[7].astype(int).tolist())}
    pygame.event.post(pygame.event.Event(pygame.MOUSEBUTTONDOWN, click))
    window.show(scenes[2])
    assert window.show_what.selected == 7
    press(pygame.K_ESCAPE)
    window.show(scenes[3])
    assert window.show_what.selected is None


def test_s_saves_what_is_seen_or_says_in_the_window_that_it_cannot(
    window, scenes, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    window.show(scenes[0])
    press(pygame.K_s)
    window.show(scenes[1])
    (file,) = tmp_path.glob("es1-*.png")
    assert pygame.image.load(file).get_width() == 480
    file.unlink()
    tmp_path.rmdir()
    press(pygame.K_s)
    window.show(scenes[2])
    assert "cannot write es1" in window._notice[0]


@pytest.mark.parametrize("key", [pygame.K_q, None])
def test_it_closes_and_shows_nothing_from_then_on(window, scenes, key, drawn):
    window.show(scenes[0])
    if key is None:
        pygame.event.post(pygame.event.Event(pygame.QUIT))
    else:
        press(key)
    window.show(scenes[1])
    assert window.closed
    n = len(drawn)
    window.show(scenes[2])
    assert len(drawn) == n
    window.close()


def test_a_screen_that_nobody_sees_is_no_display(window, scenes, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(windows.sys, "platform", "linux")
    with pytest.raises(ConfigError, match=r"DISPLAY is not set\); take frames, a video or"):
        window.show(scenes[0])


@pytest.mark.parametrize("speed", [0.0, -1.0, 257.0, float("nan")])
def test_a_speed_out_of_bounds_is_refused(speed, busy):
    with pytest.raises(ConfigError, match=r"must be 0.1 to 256 times real time"):
        Window(stage_of(busy, "nc"), 480, speed)
