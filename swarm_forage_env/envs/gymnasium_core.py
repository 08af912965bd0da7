"""Worlds side by side as Gymnasium shows them: one flat Box for all robots that learn."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Discrete, MultiDiscrete

from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.envs.actions import as_array
from swarm_forage_env.envs.array_env import ArrayEnv, Infos
from swarm_forage_env.envs.episodes import parts_of
from swarm_forage_env.envs.notebook import title_of
from swarm_forage_env.envs.render import EnvRenderer, Frame
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.viewer import check_render_mode


class JointEnvCore:
    """W worlds, of each of which the first robot learns, or all do.

    A world is a row: the observations of its learners one after another, and so their actions,
    unless `action_shape` is set to another shape of the same numbers.
    """

    def __init__(self, n_worlds: int, single_learner: bool, options: Mapping[str, Any]) -> None:
        """So many worlds under the keywords of `parallel_env`."""
        rest = dict(options)
        self.render_mode = rest.pop("render_mode", None)
        check_render_mode(self.render_mode)
        if single_learner:
            rest.setdefault("learners", 1)
        self.env = env = ArrayEnv(n_worlds=n_worlds, **rest)
        moved_by = title_of(rest.get("controller"), env)
        self._screen = EnvRenderer(env, self.render_mode, moved_by)
        self._n_worlds = n_worlds
        self.learners = env.learners
        self.observation_space = repeated(env.observation_space, len(self.learners))
        self.action_space = joint_actions(env.action_space, len(self.learners))
        self.action_shape = self.action_space.shape
        self._is_team_reward = env.config.reward == "team"
        self._has_begun = False
        self._unshaped: Infos = {}

    @property
    def over(self) -> bool:
        """The episode has ended, in all worlds alike."""
        return self._has_begun and bool(self.env.is_over.all())

    def reset(
        self,
        seeds: Sequence[int | None],
        options: Mapping[str, Any] | None = None,
        worlds: Sequence[int] | None = None,
    ) -> Float32[Array, "worlds numbers"]:
        """Start these worlds anew, or all, each from its seed; what the learners observe."""
        observations, self._unshaped = self.env.reset(seeds, worlds, options)
        self._has_begun = True
        self._screen.follow()
        return self._joined(observations)

    def step(
        self,
        actions: Any,  # noqa: ANN401 whatever was passed
    ) -> tuple[
        Float32[Array, "worlds numbers"], Float64[Array, "worlds learners"], Bool[Array, " worlds"]
    ]:
        """One decision period; a refused action leaves everything as it was."""
        if not self._has_begun:
            raise ResetNeeded("the episode has not begun: call reset() first")
        rows = self.env.actions.rows(self._as_rows(actions))
        observations, rewards, _, truncated, self._unshaped = self.env.advance(rows)
        self._screen.follow()
        return self._joined(observations), rewards, truncated

    def snapshot(self) -> Any:  # noqa: ANN401 for `restore` alone
        """All that the next steps depend on."""
        return self.env.snapshot(), self._has_begun

    def restore(self, snapshot: Any) -> None:  # noqa: ANN401 of `snapshot`
        """Go on as when the snapshot was taken."""
        of_array, has_begun = parts_of(snapshot, 2)
        self.env.restore(of_array)
        self._has_begun = has_begun

    def joint(self, rewards: Float64[Array, "worlds learners"]) -> Float64[Array, " worlds"]:
        """One reward for each world: the learners' sum, or for `team` what each of them gets."""
        return rewards[:, 0].copy() if self._is_team_reward else rewards.sum(axis=1)

    def infos(self) -> dict[str, Float64[Array, " worlds"]]:
        """What is logged: counts are summed over the learners of a world, the rest averaged."""
        log, counts = self.env.log(), self.env.truth.counts
        found = {
            name: log[:, :, k].sum(axis=1) if name in counts else log[:, :, k].mean(axis=1)
            for k, name in enumerate(self.env.infos)
        }
        for name, value in self._unshaped.items():
            found[name] = self.joint(value) if value.ndim == 2 else value
        return found

    def render(self) -> list[Frame | None]:
        """The frame of each world; None where it is on the screen."""
        if not self._has_begun:
            raise ResetNeeded("the episode has not begun: call reset() first")
        return self._screen.draw()

    def html(self, kind: str) -> str:
        """What a notebook shows of an environment whose class is called so."""
        return self._screen.html(kind)

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _joined(
        self, observations: Float32[Array, "worlds learners numbers"]
    ) -> Float32[Array, "worlds numbers"]:
        """A row for each world, which keeps nothing else alive."""
        return observations.reshape(self._n_worlds, -1)

    def _as_rows(self, actions: Any) -> Array:  # noqa: ANN401 whatever was passed
        """A row for each learner; ConfigError for another shape."""
        shape = (self._n_worlds, *self.action_shape)
        given = as_array(actions)
        if given.shape[:1] != shape[:1]:
            raise ConfigError(
                f"actions of shape {given.shape}: must be {shape}, one for each world"
            )
        if given.shape != shape:
            names = ", ".join(self.env.action_layout.names)
            raise ConfigError(
                f"action of shape {given.shape[1:]}: must be {shape[1:]}; for each robot that"
                f" learns, {names}"
            )
        return given.reshape(-1, *self.env.action_shape)


def repeated(box: Box, times: int) -> Box:
    """A Box that holds another so many times."""
    return Box(np.tile(box.low, times), np.tile(box.high, times), dtype=np.float32)


def joint_actions(space: Box | Discrete[Any], n_learners: int) -> Any:  # noqa: ANN401 a space
    """The space of the actions of all learners together: a Box, or a choice for each."""
    if isinstance(space, Box):
        return repeated(space, n_learners)
    return space if n_learners == 1 else MultiDiscrete([space.n] * n_learners)
