"""The live window: keys, pace, selection, a robot driven, on a display that is only in memory."""

import numpy as np
import pygame
import pytest

from swarm_forage_env import swarm_forage_v2
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.manual_policy import ManualPolicy, action_of
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering import window as windows
from swarm_forage_env.rendering.layout import Layout
from swarm_forage_env.rendering.window import Window
from swarm_forage_env.task import stage_of
from tests.rendering.scenes import scenes_of


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
    return scenes_of(Loop(busy, find_controller("ssgikf"), [1]), 59)


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
    with pytest.raises(ConfigError, match=r"DISPLAY is not set\); make frames, a video or"):
        window.show(scenes[0])


few = {"decision_period": 1, "max_cycles": 40, "physics": "kinematic"}


@pytest.fixture
def driven(clock):
    """An environment with a window, in which robot 3 is driven."""
    made = swarm_forage_v2.parallel_env("es1", render_mode="human", **few)
    made.reset(seed=1)
    made.window.speed = 3.0
    yield made, ManualPolicy(made, 3)
    made.close()


def step(made, policy, times=1):
    """Let robot 3 be driven and the others stand; how far and how much it turned."""
    before = made.world.robots["pose"][0].copy()
    for _ in range(times):
        actions = dict.fromkeys(made.agents, np.array([-1.0, 0.0], np.float32))
        actions["epuck_3"] = policy(None, "epuck_3")
        made.step(actions)
    after = made.world.robots["pose"][0]
    way = after[3, :2] - before[3, :2]
    ahead = way @ [np.cos(before[3, 2]), np.sin(before[3, 2])]
    turn = np.angle(np.exp(1j * (after[3, 2] - before[3, 2])))
    return float(ahead), float(turn)


def test_a_robot_goes_for_as_long_as_an_arrow_is_held(driven):
    made, policy = driven
    assert policy.agent == "epuck_3"
    assert step(made, policy, 3) == pytest.approx((0.0, 0.0), abs=0.02)
    press(pygame.K_UP)
    step(made, policy)  # the window reads the key while it shows this step
    ahead, _ = step(made, policy, 5)
    assert ahead == pytest.approx(5 * 0.1 * made.scenario.robot.cruise_speed, rel=0.3)
    press(pygame.K_UP, pygame.KEYUP)
    step(made, policy)
    assert step(made, policy, 3)[0] == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(("key", "side"), [(pygame.K_LEFT, 1.0), (pygame.K_RIGHT, -1.0)])
def test_left_and_right_turn_on_the_spot(driven, key, side):
    made, policy = driven
    press(key)
    step(made, policy)
    ahead, turn = step(made, policy, 5)
    assert side * turn > 0.1
    assert abs(ahead) < 0.02
    assert not made.window.paused, "an arrow is no step any more"


def test_the_driven_robot_is_selected_and_other_keys_still_work(driven):
    made, policy = driven
    assert made.window.show_what.selected == 3
    made.window.speed = 1.0
    press(pygame.K_t)
    press(pygame.K_PLUS)
    step(made, policy)
    assert made.window.speed == 2.0
    assert not made.window.show_what.trails
    made.window.speed = 3.0
    press(pygame.K_q)
    step(made, policy)
    assert made.window.closed
    assert policy(None, "epuck_3").tolist() == [-1.0, 0.0]


def test_a_window_that_lost_the_focus_holds_no_arrow(driven):
    made, policy = driven
    press(pygame.K_UP)
    step(made, policy)
    assert made.window.arrows == (True, False, False)
    pygame.event.post(pygame.event.Event(pygame.WINDOWFOCUSLOST))
    step(made, policy)
    assert made.window.arrows == (False, False, False)


def test_agents_in_turn_are_driven_as_pettingzoo_has_it(clock):
    env = swarm_forage_v2.env("es1", render_mode="human", decision_period=1, max_cycles=3)
    env.reset(seed=0)
    env.unwrapped.window.speed = 3.0
    manual_policy = swarm_forage_v2.ManualPolicy(env)
    assert manual_policy.available_agents["epuck_9"] == 9
    press(pygame.K_UP)
    given = []
    for agent in env.agent_iter():
        observation, _, termination, truncation, _ = env.last()
        if termination or truncation:
            action = None
        elif agent == manual_policy.agent:
            action = manual_policy(observation, agent)
            given.append(action.tolist())
        else:
            action = env.action_space(agent).sample()
        env.step(action)
    assert given == [[-1.0, 0.0], [1.0, 0.0], [1.0, 0.0]]
    env.close()


def test_what_cannot_be_driven_is_refused():
    def made(**options):
        return swarm_forage_v2.parallel_env(**{"render_mode": "human"} | few | options)

    with pytest.raises(ConfigError, match="make the environment with render_mode='human'"):
        ManualPolicy(made(render_mode="rgb_array"))
    for options in ({"learn": "weighting"}, {"action": "wheels"}, {"discrete": True}):
        with pytest.raises(ConfigError, match="keys drive learn='motion' with action='drive'"):
            ManualPolicy(made(**options))
    with pytest.raises(ConfigError, match="agent_id=10: must be 0 to 9"):
        ManualPolicy(made(), 10)
    with pytest.raises(UnknownNameError, match="agent driven by hand"):
        ManualPolicy(made())(None, "epuck_1")


def test_robots_that_visit_waypoints_turn_as_they_speed_up():
    names = ("drive.strength", "drive.turn")
    assert action_of((False, False, False), names).tolist() == [-1.0, 0.0]
    assert action_of((False, True, False), names).tolist() == [1.0, 1.0]
    assert action_of((True, False, True), names).tolist() == [1.0, -1.0]
