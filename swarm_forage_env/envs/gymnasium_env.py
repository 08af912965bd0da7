"""Gymnasium environments: `LearnerEnv`, `JointEnv` and `TupleEnv`."""

from collections.abc import Mapping, Sequence
from copy import copy, deepcopy
from typing import Any, ClassVar, Unpack

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space, Tuple

from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.envs.actions import as_array
from swarm_forage_env.envs.array_env import ArrayEnv, Infos
from swarm_forage_env.envs.episodes import checked_options, parts_of
from swarm_forage_env.envs.keywords import SingleEnvOptions
from swarm_forage_env.envs.make import refuse_keywords_of_blocks
from swarm_forage_env.envs.pettingzoo_env import parallel_env
from swarm_forage_env.envs.render import Frame, ShownEnv
from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.random_streams import checked_seed, drawn_seed
from swarm_forage_env.rendering.viewer import check_render_mode

METADATA: dict[str, object] = {
    name: parallel_env.metadata[name] for name in ("render_modes", "render_fps")
}
"""Metadata shared with the PettingZoo environment."""


class JointWorlds(ShownEnv):
    """W worlds; in each, the first robot or all robots learn.

    Each world is one row: the concatenated observations of its learners; if `is_shared`, each
    learner is one. So are their actions, unless `_action_shape` sets another shape of the same
    size.
    """

    single_learner: ClassVar[bool] = False
    is_shared: ClassVar[bool] = False

    def _make(self, n_rows: int, options: Mapping[str, Any]) -> None:
        rest = dict(options)
        render_mode = rest.pop("render_mode", None)
        check_render_mode(render_mode)
        refuse_keywords_of_blocks(rest)
        if self.single_learner:
            rest.setdefault("learners", 1)
        self._rows_in_world = len(ArrayEnv(**rest).learners) if self.is_shared else 1
        if n_rows % self._rows_in_world:
            raise ConfigError(
                f"num_envs={n_rows}: each robot that learns is an environment, and a world has"
                f" {self._rows_in_world}; use a multiple of {self._rows_in_world}"
            )
        env = ArrayEnv(n_worlds=n_rows // self._rows_in_world, **rest)
        self._show(env, render_mode)
        own, n_together = env.observation_space, len(env.learners) // self._rows_in_world
        if self.single_learner and n_together > 1:
            raise ConfigError(
                f"learners={shown(rest['learners'])}: one robot learns in this environment; name"
                " one, or use that of all robots, whose id ends with -Joint-v2"
            )
        self._joint_observations = own if n_together == 1 else repeated(own, n_together)
        self._joint_actions = joint_actions(env.action_space, n_together)
        self._action_shape: tuple[int, ...] = self._joint_actions.shape or ()
        self._is_team_reward = env.config.reward == "team"
        self._unshaped: Infos = {}

    def _begin(
        self,
        seeds: Sequence[int | None],
        options: Mapping[str, object] | None = None,
        worlds: Sequence[int] | None = None,
    ) -> Float32[Array, "rows numbers"]:
        """Reset these worlds, or all, each to its seed, and return the observations."""
        observations, self._unshaped = self.array_env.reset(seeds, worlds, options)
        self._screen.follow()
        return self._rows(observations)

    def _advance(
        self, actions: object
    ) -> tuple[
        Float32[Array, "rows numbers"], Float64[Array, "worlds learners"], Bool[Array, " worlds"]
    ]:
        """Run one decision period; a refused action leaves the worlds unchanged."""
        self.array_env.episodes.check_begun()
        rows = self.array_env.actions.rows(self._as_rows(actions))
        observations, rewards, _, truncated, self._unshaped = self.array_env.advance(rows)
        self._screen.follow()
        return self._rows(observations), rewards, truncated

    def _rows(self, values: Array) -> Array:
        """Return values of learners, whose first axes are worlds and learners, as rows."""
        return values.reshape(len(values) * self._rows_in_world, -1)

    def _of_rows(self, values: Array) -> Array:
        """Return values of worlds for each row."""
        return values if self._rows_in_world == 1 else values.repeat(self._rows_in_world)

    def _joint(self, rewards: Float64[Array, "worlds learners"]) -> Float64[Array, " rows"]:
        """Return one reward for each row: the sum over its learners, or the team's mean."""
        rows = self._rows(rewards)
        return rows[:, 0].copy() if self._is_team_reward else rows.sum(axis=1)

    def _joint_infos(self) -> dict[str, Float64[Array, " rows"]]:
        """Return the logged values: counts are summed over a row's learners, others averaged."""
        env = self.array_env
        log, counts = env.log(), env.truth.counts
        infos = {}
        for k, name in enumerate(env.infos):
            rows = self._rows(log[:, :, k])
            infos[name] = rows.sum(axis=1) if name in counts else rows.mean(axis=1)
        for name, value in self._unshaped.items():
            is_world = value.ndim == 1
            infos[name] = self._of_rows(value) if is_world else self._rows(value).sum(axis=1)
        infos["unshaped_reward"] = self._joint(self._unshaped["unshaped_reward"])
        return infos

    def _frames(self) -> list[Frame | str | None]:
        """Return the frame of each world, or None if a window shows it."""
        self.array_env.episodes.check_begun()
        return self._screen.draw()

    def _as_rows(self, actions: object) -> Array:
        env, row = self.array_env, "robot" if self.is_shared else "world"
        shape = (env.n_worlds * self._rows_in_world, *self._action_shape)
        array = as_array(actions)
        if array.shape[:1] != shape[:1]:
            raise ConfigError(
                f"actions of shape {array.shape}: must be {shape}, one for each {row}"
            )
        if array.shape != shape:
            raise ConfigError(
                f"action of shape {array.shape[1:]}: must be {shape[1:]}; for each robot that"
                f" learns, {env.actions.form.wanted}"
            )
        return array.reshape(-1, *env.action_shape)


def repeated(box: Box, times: int) -> Box:
    """Return a Box that repeats another Box `times` times."""
    return Box(np.tile(box.low, times), np.tile(box.high, times), dtype=np.float32)


def joint_actions(space: Box | Discrete, n_learners: int) -> Box | Discrete | MultiDiscrete:
    """Return the joint action space: a Box, or one choice for each learner."""
    if isinstance(space, Box):
        return repeated(space, n_learners)
    return space if n_learners == 1 else MultiDiscrete([int(space.n)] * n_learners)


class _SwarmEnv(JointWorlds, gym.Env[Any, Any]):
    metadata: dict[str, object] = METADATA
    _spec: EnvSpec | None = None

    def __init__(self, **options: Unpack[SingleEnvOptions]) -> None:
        self._make(1, options)
        self.observation_space: Space[Any] = self._joint_observations
        self.action_space: Space[Any] = self._joint_actions

    @property
    def spec(self) -> EnvSpec | None:
        """Specification given by `gymnasium.make`; `max_episode_steps` is the episode length."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = copy(spec)
        if self._spec is not None and self._spec.max_episode_steps is None:
            self._spec.max_episode_steps = self.max_cycles

    def reset(
        self, *, seed: int | None = None, options: dict[str, object] | None = None
    ) -> tuple[Any, dict[str, object]]:
        """Start an episode; a seed fixes it and all later ones that are started without a seed."""
        seed = None if seed is None else checked_seed(seed)
        # refuse invalid options before a seed is drawn:
        self.array_env.episodes.scenario_under(checked_options(options))
        super().reset(seed=seed)
        world_seed = drawn_seed(self.np_random) if seed is None else seed
        (observation,) = self._begin([world_seed], options)
        return self._in_space(observation), self._info()

    def step(self, action: object) -> tuple[Any, Any, bool, bool, dict[str, object]]:
        """Run one decision period; a refused action leaves the worlds unchanged."""
        observations, rewards, truncated = self._advance([action])
        observation = self._in_space(observations[0])
        return observation, self._reward(rewards), False, bool(truncated[0]), self._info()

    def snapshot(self) -> object:
        return super().snapshot(), deepcopy(self.np_random)

    def restore(self, snapshot: object) -> None:
        joint, generator = parts_of(snapshot, 2)
        super().restore(joint)
        self.np_random = deepcopy(generator)

    def render(self) -> Any:  # noqa: ANN401 as in Gymnasium
        """Return the current frame as an RGB array (`ansi`: as text); None if a window shows it.

        Raises ConfigError if no `render_mode` was given or a window finds no display.
        """
        return self._frames()[0]

    def _info(self) -> dict[str, object]:
        return {name: float(value[0]) for name, value in self._joint_infos().items()}

    def _in_space(self, observation: Float32[Array, " numbers"]) -> object:
        return observation

    def _reward(self, rewards: Float64[Array, "1 learners"]) -> float | list[float]:
        return float(self._joint(rewards)[0])


class LearnerEnv(_SwarmEnv):
    """Environment in which one robot learns; its team-mates keep the layers of `controller`.

    The keywords are those of `parallel_env`. Observation, action, reward and info are those of the
    first robot; with `reward="team"` the reward is the mean over the swarm, team-mates included.
    With `learn="everything"` the others receive its range and bearing, but not its messages.

    >>> env = LearnerEnv(scenario="near")
    >>> observation, info = env.reset(seed=0)
    >>> env.action_space.shape  # speed and turn
    (2,)
    """

    single_learner = True


class JointEnv(_SwarmEnv):
    """Environment in which one learner steers all robots, concatenated in one Box.

    The keywords are those of `parallel_env`; `observation_layout` and `action_layout` describe the
    features of one robot. With `reward="own"` the reward is the sum over the robots, the round
    trips of the step; with `reward="team"` it is their mean. In the info, counts are summed over
    the robots and other values are averaged.

    >>> JointEnv(scenario="near").action_space.shape  # speed and turn of five robots
    (10,)
    """


class TupleEnv(_SwarmEnv):
    """Environment in which all robots learn, with the API of level-based foraging and EPyMARL.

    Spaces, observations and actions are tuples and rewards a list, with an entry for each of
    `n_agents` robots. Actions are Discrete unless `discrete=False`. The other keywords are those of
    `parallel_env`. Gymnasium's vector environments do not take lists of rewards.

    >>> env = TupleEnv(scenario="near")
    >>> observations, info = env.reset(seed=0)
    >>> len(observations), env.n_agents
    (5, 5)
    """

    def __init__(self, **options: Unpack[SingleEnvOptions]) -> None:
        options.setdefault("discrete", True)
        super().__init__(**options)
        env = self.array_env
        self.n_agents = len(env.learners)
        self._action_shape = (self.n_agents, *env.action_shape)
        self.action_space = Tuple([env.action_space] * self.n_agents)
        self.observation_space = Tuple([env.observation_space] * self.n_agents)

    def _in_space(self, observation: Float32[Array, " numbers"]) -> object:
        return tuple(row.copy() for row in observation.reshape(self.n_agents, -1))

    def _reward(self, rewards: Float64[Array, "1 learners"]) -> list[float]:
        each: list[float] = rewards[0].tolist()
        return each
