"""The environment on arrays: W worlds side by side. Every API in this folder wraps it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.envs.config import EnvConfig, n_steps
from swarm_forage_env.envs.rewards import REWARDS, shaping
from swarm_forage_env.interface import CORRECT, REPLACE, Controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import task_of


class ArrayEnv:
    """Worlds, controllers, spaces and rewards; a row of every array is a robot.

    With a decision period of k ticks an action is held for k ticks, and the rewards of all k
    are added up. A weight g held so applies to every exchange that ends in these ticks, while
    the observation shows the last tick only: for `learn="weighting"` k = 1 is what the
    hand-written rules have.

    Of each world the first robots learn: all, or the one of a single learner.
    """

    def __init__(
        self,
        scenario: Any,  # noqa: ANN401 of any task
        config: EnvConfig,
        controller: Controller,
        seeds: Sequence[int],
        single_learner: bool = False,
    ) -> None:
        """One world for each seed, ready to step."""
        self.config, self.n_cycles = config, n_steps(scenario, config)
        self.task = task_of(scenario)
        self._policy = self.task.policies[config.learn]
        no_layers = self.task.no_layers if config.learn == "everything" else None
        self.loop = Loop(scenario, no_layers or controller, seeds, config.physics, config.threads)
        self.world = self.loop.world
        self.n_learners = 1 if single_learner else self.world.n_robots
        self._hand_over()
        self.agents = [f"{self.task.agent}_{k}" for k in range(self.world.n_robots)]
        ticks = max(scenario.n_ticks, self.n_cycles * config.decision_period)
        bounds = self.task.bounds(scenario, ticks, getattr(controller, "message_path", 0.0))
        self.observation_layout = self._policy.layout(bounds)
        self.action_layout = self._policy.action
        running = self.loop.controller
        self.truth = self.task.global_state(self.world, running, self.agents, bounds)
        self._reward = REWARDS[config.reward]
        self._potential = self.task.potential(self.world)

    @property
    def infos(self) -> tuple[str, ...]:
        """The names of what is logged of each robot."""
        names: tuple[str, ...] = self.truth.infos
        return names

    def reset(self, seeds: Sequence[int]) -> Float32[Array, "rows numbers"]:
        """Start every world anew, each from its seed; what every robot observes."""
        self.loop.reset(seeds)
        return self.observe()

    def observe(self) -> Float32[Array, "rows numbers"]:
        """What every robot observes: a fresh array."""
        shape = (self.world.n_worlds, self.world.n_robots, len(self.observation_layout))
        out = np.empty(shape, np.float32)
        self._policy.observe(self.world, self.loop.controller, out)
        return out.reshape(-1, shape[2])

    def state(self, share_gone: float) -> Float32[Array, " numbers"]:
        """The truth about the first world, as the layout of `truth` says."""
        return np.asarray(self.truth.state(share_gone)[0])

    def log(self) -> list[list[float]]:
        """What is logged of each robot, in the order of `infos`."""
        numbers: list[list[float]] = self.truth.log().tolist()
        return numbers

    def step(
        self, action: Float32[Array, "learners numbers"]
    ) -> tuple[Float32[Array, "rows numbers"], Float64[Array, " rows"]]:
        """Hold an action, known to be within its space, for a decision period.

        A row for each learner; what all robots observe and are given.
        """
        shape = (self.world.n_worlds, self.n_learners, len(self.action_layout))
        self._policy.act(self.world, self.loop.controller, action.reshape(shape))
        config, is_shaped = self.config, self.config.shaping > 0.0
        before = self._potential() if is_shaped else None
        earned = np.zeros((self.world.n_worlds, self.world.n_robots))
        for _ in range(config.decision_period):
            self.loop.step()
            earned += self.world.robots["reward"]
        if before is not None:
            added = shaping(before, self._potential(), config.discount, config.shaping)
            earned += added.reshape(earned.shape)
        return self.observe(), self._reward(earned).ravel()

    def _hand_over(self) -> None:
        """Mark the layers of the learners as theirs."""
        action = self.world.robots["action"]
        for layer in self._policy.replaces:
            is_residual = self.config.residual and layer == "motion"
            action[layer][:, : self.n_learners] = CORRECT if is_residual else REPLACE
