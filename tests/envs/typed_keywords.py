"""Keywords of every API, for `test_keywords.py`: a type checker refuses the lines marked."""

from typing import Any, assert_type

import gymnasium
import numpy as np

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import ArrayEnv, OwnName, array_env, env, find_scenario, parallel_env, raw_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.gymnasium_env import JointEnv, LearnerEnv, TupleEnv
from swarm_forage_env.envs.gymnasium_vector import LearnerVectorEnv
from swarm_forage_env.envs.keywords import SingleEnvOptions
from swarm_forage_env.foraging.episode import ForagingEpisode
from training.policy_card import save_policy_card
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv


class Clock:
    """An observation of the user's own."""

    def features(self, scenario: Any, agents: Any) -> Any:
        """What each number is."""

    def write(self, context: Any, out: Any) -> None:
        """Write the numbers."""


def fast(before: Any, after: Any, events: Any) -> np.ndarray:
    """A reward of the user's own."""
    return np.zeros(1)


def accepted() -> None:
    """Calls that work, and that a type checker takes."""
    parallel_env("es1", "weighting", "ssgiff:beta=0.01", "ansi", n_robots=5, reward="team")
    parallel_env("mine.toml", learn=OwnName("cleaning"), learners=["epuck_0", 3], physics="rigid")
    parallel_env("es1", observation=["layer", Clock, Clock()], reward=fast, discrete=(3, 5))
    parallel_env(find_scenario("es1", {"radio.max_range": 0.2}), controller=["nc"] * 10)
    parallel_env(controller={"*": "nc", 0: "ssgikf"}, randomise={"area_distance": (0.8, 1.5)})
    changes: dict[str, Any] = {"radio.max_range": 0.2}
    parallel_env("es1", residual=True, **changes)
    gymnasium.make("SwarmForage/Near-v2", **SingleEnvOptions(learn="both", stack=2))


def refused() -> None:
    """Calls of which a type checker refuses each."""
    parallel_env("es1", "weightings")  # refused
    parallel_env("es1", learn="motions")  # refused
    parallel_env("es1", decision_periodd=5)  # refused
    parallel_env("es1", action="weels")  # refused
    parallel_env("es1", observation="layers")  # refused
    parallel_env("es1", physics="rigit")  # refused
    parallel_env("es1", reward="teams")  # refused
    parallel_env("es1", step_on="ticks")  # refused
    parallel_env("es1", render_mode="rgb")  # refused
    parallel_env("es1", stack="2")  # refused
    raw_env("es1", stak=2)  # refused
    env("es1", learn="motions")  # refused
    ArrayEnv("es1", 4, walks=True)  # refused
    ArrayEnv("es1", 4, device="cude")  # refused
    array_env("es1", n_world=4)  # refused
    LearnerEnv(scenario="near", learn="motions")  # refused
    JointEnv(scenari="near")  # refused
    TupleEnv(scenario="near", discrete="yes")  # refused
    LearnerVectorEnv(4, learn="motions")  # refused
    SwarmVecEnv("near", 4, learn="motions")  # refused
    save_policy_card("policy.pt", "es1", decision_periodd=5)  # refused
    policy_controller(fast, learn="motions")  # refused
    gymnasium.make("SwarmForage/Near-v2", **SingleEnvOptions(learn="motions"))  # refused


def episodes() -> None:
    """What `run_episodes` returns has the fields of its task."""
    episodes = run_episodes(find_scenario("es1"), find_controller("ssgikf"), [0])
    assert_type(episodes, list[ForagingEpisode])
    assert episodes[0].round_trip  # refused
    waypoints = run_episodes(find_scenario("waypoints-05"), find_controller("boids-adaptive"), [0])
    assert waypoints[0].round_trips  # refused
