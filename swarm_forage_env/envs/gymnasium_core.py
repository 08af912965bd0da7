"""Worlds side by side as Gymnasium shows them: one flat Box for all robots that learn."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.envs.actions import Actions
from swarm_forage_env.envs.make import make_array_env
from swarm_forage_env.envs.render import EnvRenderer, Frame, title_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.viewer import check_render_mode
from swarm_forage_env.spaces import Layout


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
        parts = {name: rest.pop(name) for name in ("scenario", "controller") if name in rest}
        seeds = (0,) * n_worlds
        self.env = env = make_array_env(seeds, rest, **parts, single_learner=single_learner)
        moved_by = title_of(parts.get("controller"), rest.get("learn", "motion"))
        self._screen = EnvRenderer(env, self.render_mode, moved_by)
        self.n_cycles = env.n_cycles
        self._n_worlds, self._n_robots = n_worlds, env.world.n_robots
        self.learners = env.agents[:1] if single_learner else env.agents
        self.observation_space = _repeated(env.observation_layout, len(self.learners))
        self.action_space = _repeated(env.action_layout, len(self.learners))
        self.action_shape = self.action_space.shape
        self._is_team_reward = rest.get("reward") == "team"
        names = self.learners
        if n_worlds > 1:
            names = [f"{name} of world {w}" for w in range(n_worlds) for name in self.learners]
        self._actions = Actions(names, env.action_layout)
        self._cycles: int | None = None

    @property
    def over(self) -> bool:
        """The episode has ended, in all worlds alike."""
        return self._cycles is not None and self._cycles >= self.n_cycles

    def reset(self, seeds: Sequence[int]) -> Float32[Array, "worlds numbers"]:
        """Start every world anew, each from its seed; what the learners observe."""
        observations = self.env.reset(seeds)
        self._cycles = 0
        self._screen.follow()
        return self._of_learners(observations)

    def step(
        self,
        actions: Any,  # noqa: ANN401 whatever was passed
    ) -> tuple[Float32[Array, "worlds numbers"], Float64[Array, "worlds learners"]]:
        """One decision period; a refused action leaves everything as it was."""
        if self._cycles is None:
            raise ResetNeeded("the episode has not begun: call reset() first")
        if self.over:
            raise ResetNeeded(f"step after the end, at {self._cycles} cycles: call reset() first")
        rows = self._actions.rows(self._as_rows(actions))
        observations, rewards = self.env.step(rows)
        self._cycles += 1
        self._screen.follow()
        earned = rewards.reshape(self._n_worlds, -1)[:, : len(self.learners)]
        return self._of_learners(observations), earned

    def joint(self, rewards: Float64[Array, "worlds learners"]) -> Float64[Array, " worlds"]:
        """One reward for each world: the learners' sum, or for `team` what each of them gets."""
        return rewards[:, 0].copy() if self._is_team_reward else rewards.sum(axis=1)

    def infos(self) -> dict[str, Float64[Array, " worlds"]]:
        """What is logged: counts are summed over the learners of a world, the rest averaged."""
        log = self._of_robots(self.env.truth.log())
        return {
            name: log[:, :, k].sum(axis=1)
            if name in self.env.truth.counts
            else log[:, :, k].mean(axis=1)
            for k, name in enumerate(self.env.infos)
        }

    def render(self) -> list[Frame | None]:
        """The frame of each world; None where it is on the screen."""
        if self._cycles is None:
            raise ResetNeeded("the episode has not begun: call reset() first")
        return self._screen.draw()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _of_robots(self, rows: Array) -> Array:
        """A view of the learners' rows, world by world."""
        return rows.reshape(self._n_worlds, self._n_robots, -1)[:, : len(self.learners)]

    def _of_learners(
        self, observations: Float32[Array, "rows numbers"]
    ) -> Float32[Array, "worlds numbers"]:
        """A row for each world, which keeps nothing else alive."""
        return self._of_robots(observations).reshape(self._n_worlds, -1).copy()

    def _as_rows(self, actions: Any) -> Array:  # noqa: ANN401 whatever was passed
        """A row for each learner; ConfigError for another shape."""
        shape = (self._n_worlds, *self.action_shape)
        try:
            given = np.asarray(actions)
        except ValueError as error:
            raise ConfigError(f"action={actions!r}: {error}") from None
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
        return given.reshape(-1, len(self.env.action_layout))


def _repeated(layout: Layout, times: int) -> Box:
    """A Box that holds a layout so many times."""
    box = layout.box()
    return Box(np.tile(box.low, times), np.tile(box.high, times), dtype=np.float32)
