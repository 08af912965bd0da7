"""Arrow keys drive one robot in the window, on a display that is only in memory."""

import numpy as np
import pygame
import pytest

from swarm_forage_env import swarm_forage_v2
from swarm_forage_env.envs.manual_policy import ManualPolicy, action_of
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.rendering import window as windows
from tests.rendering.test_window import press

few = {"decision_period": 1, "max_cycles": 40, "physics": "kinematic"}


@pytest.fixture(autouse=True)
def hurried(monkeypatch):
    """Nobody waits."""
    monkeypatch.setattr(windows.time, "sleep", lambda seconds: None)


@pytest.fixture
def driven():
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


def test_agents_in_turn_are_driven_as_pettingzoo_has_it():
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
        with pytest.raises(ConfigError, match="only learn='motion' with action='drive'"):
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
