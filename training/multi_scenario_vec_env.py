"""A stable-baselines3 vector environment over several scenarios."""

import time
from collections.abc import Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from training.vec_env import Infos, SharedAttributesVecEnv, SwarmVecEnv


class MultiScenarioVecEnv(SharedAttributesVecEnv):
    """Vector environments of several scenarios, joined into one along the batch axis.

    All must have the same observation and action spaces. `stepping_s` is the wall time that all
    steps and resets took so far [s].
    """

    def __init__(self, environments: Sequence[SwarmVecEnv]) -> None:
        """Join environments of any numbers of robots; the spaces are those of the first."""
        self._environments = list(environments)
        self._ends = np.cumsum([each.num_envs for each in environments])
        self.stepping_s = 0.0
        self.render_mode = None
        first = environments[0]
        self.observation_layout = first.observation_layout
        super().__init__(int(self._ends[-1]), first.observation_space, first.action_space)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed every environment's sequence of episode seeds."""
        return [each for environment in self._environments for each in environment.seed(seed)]

    def reset(self) -> Float32[Array, "rows numbers"]:
        """Reset every world and return the observation of every robot."""
        begin = time.perf_counter()
        observed = np.concatenate([each.reset() for each in self._environments])
        self.reset_infos: Infos = [info for each in self._environments for info in each.reset_infos]
        self.stepping_s += time.perf_counter() - begin
        return observed

    def step_async(self, actions: Float32[Array, "rows numbers"]) -> None:
        """Store the actions of all robots for the next `step_wait`."""
        parts = np.split(actions, self._ends[:-1])
        for each, part in zip(self._environments, parts, strict=True):
            each.step_async(np.ascontiguousarray(part))

    def step_wait(
        self,
    ) -> tuple[Float32[Array, "rows numbers"], Float32[Array, " rows"], Array, Infos]:
        """Run one decision period and return observations, rewards, dones and infos."""
        begin = time.perf_counter()
        observed, rewards, done, infos = zip(
            *(each.step_wait() for each in self._environments), strict=True
        )
        self.stepping_s += time.perf_counter() - begin
        every = [info for each in infos for info in each]
        return np.concatenate(observed), np.concatenate(rewards), np.concatenate(done), every
