"""The state for centralised critics, and the numbers that are logged."""

import numpy as np
import pytest

from swarm_forage_env.foraging.global_state import INFOS
from swarm_forage_env.foraging.policies import LEARNABLE
from tests.beliefs import localisation_error
from tests.commands import parallel_env


def named(env):
    return dict(zip(env.state_layout.names, env.state().tolist(), strict=True))


def test_the_state_holds_the_true_poses_areas_and_time(busy, constant):
    env = parallel_env(busy, learn="weighting", max_cycles=80)
    env.reset(seed=1)
    for _ in range(60):
        env.step(constant(env, 0.5, 0.5))
    state = named(env)
    for k, (x, y, theta) in enumerate(env.world.state.pose):
        pose = [state[f"epuck_{k}.{name}"] for name in ("pose.x", "pose.y")]
        heading = [state[f"epuck_{k}.heading.{name}"] for name in ("cos", "sin")]
        assert pose == pytest.approx([x, y], abs=1e-6)
        assert heading == pytest.approx([np.cos(theta), np.sin(theta)], abs=1e-6)
    areas = [state[f"areas.{area}.{axis}"] for area in ("nest", "prey") for axis in "xy"]
    assert areas == pytest.approx([-0.35, 0.0, 0.35, 0.0])
    assert state["share_gone"] == pytest.approx(0.75)


def test_the_state_holds_the_beliefs_in_the_world_frame(busy, constant):
    env = parallel_env(busy, learn="weighting")
    env.reset(seed=1)
    while env.array_env.loop.situation.known.mean() < 0.5:
        env.step(constant(env, 0.5, 0.5))
    state, beliefs = named(env), env.array_env.loop.situation
    error = localisation_error(env.array_env.loop)
    assert not beliefs.known.all()
    for k in range(10):
        for area, name in enumerate(("nest", "prey")):
            believed = [state[f"epuck_{k}.believed.{name}.{axis}"] for axis in "xy"]
            assert state[f"epuck_{k}.known.{name}"] == beliefs.known[k, area]
            assert state[f"epuck_{k}.p.{name}"] == pytest.approx(beliefs.p[k, area])
            if beliefs.known[k, area]:
                off = np.hypot(*(believed - env.world.areas[area]))
                assert off == pytest.approx(error[k, area], abs=1e-5)
            else:
                assert believed == [0.0, 0.0]
        goals = [state[f"epuck_{k}.goal.{goal}"] for goal in ("nest", "prey", "none")]
        assert goals == beliefs.goal[k].tolist()


OF_WAYPOINTS = ("goals", "false_goals", "position_error_m")


@pytest.mark.parametrize("learn", LEARNABLE)
@pytest.mark.parametrize(("scenario", "names"), [("es1", INFOS), ("waypoints-05", OF_WAYPOINTS)])
def test_infos_are_numbers_under_the_same_keys_from_reset_on(scenario, names, learn, sampler):
    env = parallel_env(scenario, learn=learn)
    _, infos = env.reset(seed=0)
    act = sampler(env, 0)
    for _ in range(50):
        assert list(infos) == env.possible_agents
        for info in infos.values():
            assert tuple(info) == (*names, "unshaped_reward")
            assert all(type(number) is float for number in info.values())
            assert np.isfinite(list(info.values())).all()
        *_, infos = env.step(act())
