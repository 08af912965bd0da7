"""The environment as Gymnasium wants it: `LearnerEnv`, `JointEnv`, `TupleEnv`."""

from copy import copy, deepcopy
from typing import Any, ClassVar

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec
from gymnasium.spaces import Space, Tuple

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.envs.episodes import checked_options, parts_of
from swarm_forage_env.envs.gymnasium_core import JointEnvCore
from swarm_forage_env.envs.pettingzoo_env import parallel_env
from swarm_forage_env.envs.render import render_modes
from swarm_forage_env.random_streams import checked_seed, drawn_seed
from swarm_forage_env.task import World

METADATA: dict[str, Any] = {
    name: parallel_env.metadata[name] for name in ("render_modes", "render_fps")
}
"""As of the PettingZoo environment."""


class _SwarmEnv(gym.Env[Any, Any]):
    """One world of a block, in which the first robot learns, or all do."""

    metadata: dict[str, Any] = METADATA
    single_learner: ClassVar[bool] = False
    _spec: EnvSpec | None = None

    def __init__(self, **options: Any) -> None:  # noqa: ANN401 as parallel_env
        """Make the environment; `reset` starts an episode."""
        self._core = core = JointEnvCore(1, self.single_learner, options)
        self.render_mode = core.render_mode
        self.metadata = {
            **self.metadata,
            "render_modes": render_modes(self.scenario),
        }
        self.max_cycles = core.env.max_cycles
        self.observation_layout = core.env.observation_layout
        self.action_layout = core.env.action_layout
        self.observation_space: Space[Any] = core.observation_space
        self.action_space: Space[Any] = core.action_space

    @property
    def spec(self) -> EnvSpec | None:
        """What `gymnasium.make` made it of, and how long its episodes are."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = copy(spec)
        if self._spec is not None and self._spec.max_episode_steps is None:
            self._spec.max_episode_steps = self.max_cycles

    @property
    def world(self) -> World:
        """The worlds of the robots: their records are the truth."""
        return self._core.env.world

    @property
    def scenario(self) -> Any:  # noqa: ANN401 of any task
        """The scenario of the first world's episode."""
        return self.world.scenario

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode; a seed fixes it and all that follow without one."""
        seed = None if seed is None else checked_seed(seed)
        self._core.env.episodes.scenario_under(
            checked_options(options)
        )  # refused before a seed is drawn
        super().reset(seed=seed)
        world_seed = drawn_seed(self.np_random) if seed is None else seed
        (observation,) = self._core.reset([world_seed], options)
        return self._shown(observation), self._info()

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:  # noqa: ANN401
        """One decision period; a refused action leaves everything as it was."""
        observations, rewards, truncated = self._core.step([action])
        observation = self._shown(observations[0])
        return observation, self._reward(rewards), False, bool(truncated[0]), self._info()

    def snapshot(self) -> Any:  # noqa: ANN401 for `restore` alone
        """All that the next steps depend on: to be restored any number of times, and pickled."""
        return self._core.snapshot(), deepcopy(self.np_random)

    def restore(self, snapshot: Any) -> None:  # noqa: ANN401 of `snapshot`
        """Go on as when the snapshot was taken, bit for bit.

        ConfigError if it is of an environment of other options.
        """
        core, generator = parts_of(snapshot, 2)
        self._core.restore(core)
        self.np_random = deepcopy(generator)

    def render(self) -> Any:  # noqa: ANN401 as Gymnasium has it
        """The frame of this moment as rows of red, green and blue; None where it is on the screen.

        ConfigError where no `render_mode` was given, or no display is found for a window.
        """
        return self._core.render()[0]

    def close(self) -> None:
        """Close the window, if there is one."""
        self._core.close()

    def _repr_html_(self) -> str:
        """A picture of this moment and a table, for notebooks."""
        return self._core.html(type(self).__name__)

    def _info(self) -> dict[str, float]:
        return {name: float(value[0]) for name, value in self._core.infos().items()}

    def _shown(self, observation: Float32[Array, " numbers"]) -> Any:  # noqa: ANN401 of its space
        return observation

    def _reward(self, rewards: Float64[Array, "1 learners"]) -> Any:  # noqa: ANN401 one, or a list
        return float(self._core.joint(rewards)[0])


class LearnerEnv(_SwarmEnv):
    """One robot learns among team-mates that keep the hand-written layers of `controller`.

    The keywords are those of `parallel_env`. Observation, action, reward and info are the first
    robot's; with `reward="team"` it gets the mean over the swarm, its team-mates included.
    With `learn="everything"` the others do not understand it, and hear only where it is.
    """

    single_learner = True


class JointEnv(_SwarmEnv):
    """One learner steers the whole swarm: all robots in one Box, one robot after another.

    The keywords are those of `parallel_env`; `observation_layout` and `action_layout` say what
    each number of one robot is. With `reward="own"` the reward is the sum over the robots, the
    round trips of the step; with `reward="team"` it is their mean. In the info, counts are
    summed over the robots and all else is averaged.
    """


class TupleEnv(_SwarmEnv):
    """All robots learn, in the form of level-based foraging and EPyMARL.

    Spaces, observations and actions are tuples and rewards a list, with an entry for each of
    `n_agents` robots. Actions are Discrete unless `discrete=False`. The other keywords are those of
    `parallel_env`. Gymnasium's vector environments do not take lists of rewards.
    """

    def __init__(self, discrete: bool | tuple[int, int] = True, **options: Any) -> None:  # noqa: ANN401
        """Make the environment; `reset` starts an episode."""
        super().__init__(discrete=discrete, **options)
        env = self._core.env
        self.n_agents = len(self._core.learners)
        self._core.action_shape = (self.n_agents, *env.action_shape)
        self.action_space = Tuple([env.action_space] * self.n_agents)
        self.observation_space = Tuple([env.observation_space] * self.n_agents)

    def _shown(self, observation: Float32[Array, " numbers"]) -> Any:  # noqa: ANN401 of its space
        return tuple(row.copy() for row in observation.reshape(self.n_agents, -1))

    def _reward(self, rewards: Float64[Array, "1 learners"]) -> Any:  # noqa: ANN401 one, or a list
        return rewards[0].tolist()
