"""Worlds side by side in the form of Gymnasium: one flat Box for all robots that learn."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete

from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.envs.actions import as_array
from swarm_forage_env.envs.array_env import ArrayEnv, Infos
from swarm_forage_env.envs.render import Frame, ShownEnv
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.viewer import check_render_mode


class JointWorlds(ShownEnv):
    """W worlds; in each, the first robot or all robots learn.

    A world is a row: the observations of its learners one after another, and so their actions,
    unless `_action_shape` is set to another shape of the same numbers.
    """

    single_learner: ClassVar[bool] = False

    def _make(self, n_worlds: int, options: Mapping[str, Any]) -> None:
        rest = dict(options)
        render_mode = rest.pop("render_mode", None)
        check_render_mode(render_mode)
        if self.single_learner:
            rest.setdefault("learners", 1)
        env = ArrayEnv(n_worlds=n_worlds, **rest)
        self._show(env, render_mode)
        own, n_learners = env.observation_space, len(env.learners)
        self._joint_observations = own if n_learners == 1 else repeated(own, n_learners)
        self._joint_actions = joint_actions(env.action_space, n_learners)
        self._action_shape: tuple[int, ...] = self._joint_actions.shape or ()
        self._is_team_reward = env.config.reward == "team"
        self._unshaped: Infos = {}

    def _begin(
        self,
        seeds: Sequence[int | None],
        options: Mapping[str, object] | None = None,
        worlds: Sequence[int] | None = None,
    ) -> Float32[Array, "worlds numbers"]:
        """Reset these worlds, or all, each to its seed. Returns what the learners observe."""
        observations, self._unshaped = self.array_env.reset(seeds, worlds, options)
        self._screen.follow()
        joined: Float32[Array, "worlds numbers"] = observations.reshape(len(observations), -1)
        return joined

    def _advance(
        self, actions: object
    ) -> tuple[
        Float32[Array, "worlds numbers"], Float64[Array, "worlds learners"], Bool[Array, " worlds"]
    ]:
        """One decision period; a refused action leaves everything as it was."""
        self.array_env.episodes.check_begun()
        rows = self.array_env.actions.rows(self._as_rows(actions))
        observations, rewards, _, truncated, self._unshaped = self.array_env.advance(rows)
        self._screen.follow()
        return observations.reshape(len(observations), -1), rewards, truncated

    def _joint(self, rewards: Float64[Array, "worlds learners"]) -> Float64[Array, " worlds"]:
        """One reward for each world: the learners' sum, or for `team` what each of them gets."""
        return rewards[:, 0].copy() if self._is_team_reward else rewards.sum(axis=1)

    def _joint_infos(self) -> dict[str, Float64[Array, " worlds"]]:
        """What is logged: counts are summed over the learners of a world, the rest averaged."""
        env = self.array_env
        log, counts = env.log(), env.truth.counts
        infos = {
            name: log[:, :, k].sum(axis=1) if name in counts else log[:, :, k].mean(axis=1)
            for k, name in enumerate(env.infos)
        }
        for name, value in self._unshaped.items():
            infos[name] = self._joint(value) if value.ndim == 2 else value
        return infos

    def _frames(self) -> list[Frame | str | None]:
        """The frame of each world; None where it is on the screen."""
        self.array_env.episodes.check_begun()
        return self._screen.draw()

    def _as_rows(self, actions: object) -> Array:
        env = self.array_env
        shape = (env.n_worlds, *self._action_shape)
        array = as_array(actions)
        if array.shape[:1] != shape[:1]:
            raise ConfigError(
                f"actions of shape {array.shape}: must be {shape}, one for each world"
            )
        if array.shape != shape:
            names = ", ".join(env.action_layout.names)
            raise ConfigError(
                f"action of shape {array.shape[1:]}: must be {shape[1:]}; for each robot that"
                f" learns, {names}"
            )
        return array.reshape(-1, *env.action_shape)


def repeated(box: Box, times: int) -> Box:
    """A Box that holds another one several times."""
    return Box(np.tile(box.low, times), np.tile(box.high, times), dtype=np.float32)


def joint_actions(
    space: Box | Discrete[np.int64], n_learners: int
) -> Box | Discrete[np.int64] | MultiDiscrete:
    """The space of the actions of all learners together: a Box, or a choice for each."""
    if isinstance(space, Box):
        return repeated(space, n_learners)
    return space if n_learners == 1 else MultiDiscrete([int(space.n)] * n_learners)
