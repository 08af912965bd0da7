"""The environment as Gymnasium wants it: `LearnerEnv`, `JointEnv`, `TupleEnv`."""

from copy import copy, deepcopy
from typing import Any, Unpack

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec
from gymnasium.spaces import Space, Tuple

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.envs.episodes import checked_options, parts_of
from swarm_forage_env.envs.gymnasium_core import JointWorlds
from swarm_forage_env.envs.keywords import SingleEnvOptions
from swarm_forage_env.envs.pettingzoo_env import parallel_env
from swarm_forage_env.random_streams import checked_seed, drawn_seed

METADATA: dict[str, object] = {
    name: parallel_env.metadata[name] for name in ("render_modes", "render_fps")
}
"""As of the PettingZoo environment."""


class _SwarmEnv(JointWorlds, gym.Env[Any, Any]):
    metadata: dict[str, object] = METADATA
    _spec: EnvSpec | None = None

    def __init__(self, **options: Unpack[SingleEnvOptions]) -> None:
        self._make(1, options)
        self.observation_space: Space[Any] = self._joint_observations
        self.action_space: Space[Any] = self._joint_actions

    @property
    def spec(self) -> EnvSpec | None:
        """What `gymnasium.make` made it of, and how long its episodes are."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = copy(spec)
        if self._spec is not None and self._spec.max_episode_steps is None:
            self._spec.max_episode_steps = self.max_cycles

    def reset(
        self, *, seed: int | None = None, options: dict[str, object] | None = None
    ) -> tuple[Any, dict[str, object]]:
        """Start an episode; a seed fixes it and all that follow without one."""
        seed = None if seed is None else checked_seed(seed)
        # refused before a seed is drawn:
        self.array_env.episodes.scenario_under(checked_options(options))
        super().reset(seed=seed)
        world_seed = drawn_seed(self.np_random) if seed is None else seed
        (observation,) = self._begin([world_seed], options)
        return self._in_space(observation), self._info()

    def step(self, action: object) -> tuple[Any, Any, bool, bool, dict[str, object]]:
        """One decision period; a refused action leaves everything as it was."""
        observations, rewards, truncated = self._advance([action])
        observation = self._in_space(observations[0])
        return observation, self._reward(rewards), False, bool(truncated[0]), self._info()

    def snapshot(self) -> object:
        return super().snapshot(), deepcopy(self.np_random)

    def restore(self, snapshot: object) -> None:
        joint, generator = parts_of(snapshot, 2)
        super().restore(joint)
        self.np_random = deepcopy(generator)

    def render(self) -> Any:  # noqa: ANN401 as Gymnasium has it
        """The frame of this moment as rows of red, green and blue; None where it is on the screen.

        ConfigError where no `render_mode` was given, or no display is found for a window.
        """
        return self._frames()[0]

    def _info(self) -> dict[str, object]:
        return {name: float(value[0]) for name, value in self._joint_infos().items()}

    def _in_space(self, observation: Float32[Array, " numbers"]) -> object:
        return observation

    def _reward(self, rewards: Float64[Array, "1 learners"]) -> float | list[float]:
        return float(self._joint(rewards)[0])


class LearnerEnv(_SwarmEnv):
    """One robot learns among team-mates that keep the hand-written layers of `controller`.

    The keywords are those of `parallel_env`. Observation, action, reward and info are the first
    robot's; with `reward="team"` it gets the mean over the swarm, its team-mates included.
    With `learn="everything"` the others do not understand it, and hear only where it is.

    >>> env = LearnerEnv(scenario="near")
    >>> observation, info = env.reset(seed=0)
    >>> env.action_space.shape  # speed and turn
    (2,)
    """

    single_learner = True


class JointEnv(_SwarmEnv):
    """One learner steers the whole swarm: all robots in one Box, one robot after another.

    The keywords are those of `parallel_env`; `observation_layout` and `action_layout` say what
    each number of one robot is. With `reward="own"` the reward is the sum over the robots, the
    round trips of the step; with `reward="team"` it is their mean. In the info, counts are
    summed over the robots and all else is averaged.

    >>> JointEnv(scenario="near").action_space.shape  # speed and turn of five robots
    (10,)
    """


class TupleEnv(_SwarmEnv):
    """All robots learn, in the form of level-based foraging and EPyMARL.

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
