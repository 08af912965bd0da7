"""Scoring of policies in test worlds, and evaluation of a policy during training."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np
from gymnasium.spaces import Discrete

import baselines.controllers  # noqa: F401 runs the layers that are not learned
from swarm_forage_env.arrays import Array, Bool, Float64
from swarm_forage_env.envs.array_env import ArrayEnv
from training.experiment import HELD_BACK_SEEDS
from training.ladder.rungs import Keywords

Act = Callable[[Array, Bool[Array, " worlds"], bool], Array]
"""Maps observations (worlds, robots, features) to actions (worlds, robots, actions), which are
stochastic, as in training, if the last argument is True, else deterministic. The second argument
marks worlds where an episode starts: a recurrent policy keeps its states between two calls."""

ROWS = 1000  # approximate number of robots in a block

PER_ROBOT = "per_robot"
"""Suffix of the name of a score that is a mean over the robots, not their sum."""

POINTS = 8  # evaluations of a curve, evenly spread over the robot-steps


def play(
    keywords: Keywords, act: Act, seeds: Sequence[int], stochastic: bool = False
) -> list[float]:
    """Return the score of each seed's episode: round trips of the swarm, or goals of a robot."""
    n_worlds = max(1, ROWS // len(ArrayEnv(**keywords).learners))
    scores: list[float] = []
    for first in range(0, len(seeds), n_worlds):
        scores += _scores(keywords, act, seeds[first : first + n_worlds], stochastic)
    return scores


def _scores(keywords: Keywords, act: Act, seeds: Sequence[int], stochastic: bool) -> list[float]:
    env = ArrayEnv(n_worlds=len(seeds), **keywords)
    observations, _ = env.reset(list(seeds))
    score, is_scored = np.zeros(len(seeds)), np.zeros(len(seeds), np.bool_)
    over = np.ones(len(seeds), np.bool_)
    while not is_scored.all():
        observations, *_ = env.step(act(observations, over, stochastic))
        over = env.is_over
        if over.any():  # with step_on="exchange", the episodes of worlds end at different steps
            score = np.where(is_scored, score, _score(env))
            is_scored |= over
            observations, _ = env.reset(worlds=over)
    scores: list[float] = score.tolist()
    return scores


def _score(env: ArrayEnv) -> Float64[Array, " worlds"]:
    """Return the score of every world's episode so far."""
    of_robots = env.log()[:, :, 0]
    is_mean = env.task.episode.score.endswith(PER_ROBOT)
    return np.asarray(of_robots.mean(axis=1) if is_mean else of_robots.sum(axis=1))


def robot_steps_of_a_decision(keywords: Keywords) -> float:
    """Return the robot-steps of a world in one decision, a mean over an episode."""
    env = ArrayEnv(**keywords)
    kind = np.int64 if env.config.discrete else np.float32
    still = np.zeros((1, len(env.learners), *env.action_shape), kind)
    env.reset(0)
    n_steps = 0
    while not env.is_over.any():
        env.step(still)
        n_steps += 1
    return env.robot_steps / n_steps


def random_actions(keywords: Keywords, seed: int = 0) -> Act:
    """Return a policy that draws each action uniformly from the action space."""
    space, generator = ArrayEnv(**keywords).action_space, np.random.default_rng(seed)

    def act(observations: Array, begins: Bool[Array, " worlds"], stochastic: bool) -> Array:
        rows = observations.shape[:2]
        if isinstance(space, Discrete):
            return generator.integers(space.n, size=rows)
        shape = (*rows, len(space.low))
        return generator.uniform(space.low, space.high, shape).astype(np.float32)

    return act


class Point(TypedDict):
    """An evaluation on held-back seeds."""

    robot_steps: int
    wall_s: float  # wall-clock time of the training so far, without evaluations [s]
    scores: list[float]


@dataclass
class Watch:
    """Evaluation of a policy on held-back seeds during training; it keeps the best policy."""

    keywords: Keywords  # keywords of the test worlds, which a trainer adapts to its policies
    robot_steps: int  # robot-steps of the whole training
    episodes: int  # number of episodes of an evaluation
    curve: list[Point] = field(default_factory=list)
    best: Act | None = None

    def __post_init__(self) -> None:
        self._clock, self._best_score = time.perf_counter(), -np.inf

    def due(self, robot_steps: int) -> bool:
        """Return whether it is time for an evaluation."""
        return robot_steps * POINTS >= (len(self.curve) + 1) * self.robot_steps

    def evaluate(self, robot_steps: int, act: Act, copy: Callable[[], Act]) -> None:
        """Score a policy; if it is the best so far, keep its `copy`."""
        wall = time.perf_counter() - self._clock
        scores = play(self.keywords, act, list(HELD_BACK_SEEDS[: self.episodes]))
        self.curve.append({"robot_steps": robot_steps, "wall_s": round(wall, 2), "scores": scores})
        if np.mean(scores) > self._best_score:
            self.best, self._best_score = copy(), float(np.mean(scores))
        self._clock = time.perf_counter() - wall
