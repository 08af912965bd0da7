"""Gymnasium vector environments on one block of worlds, in which one robot or all robots learn."""

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.envs.episodes import Seeds, checked_options, checked_seeds
from swarm_forage_env.envs.gymnasium_env import METADATA, JointWorlds
from swarm_forage_env.envs.keywords import SingleEnvOptions
from swarm_forage_env.errors import ConfigError, checked_count, shown


class _SwarmVectorEnv(VectorEnv[Any, Any, Any], JointWorlds):
    """Worlds in parallel, equal to single environments step by step and bit for bit.

    All episodes have the same length, so all worlds are truncated and reset together. If lengths
    differ, as with `step_on="exchange"`, `autoreset_mode` must be DISABLED.
    """

    metadata: dict[str, object] = {**METADATA, "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012
    __repr__ = JointWorlds.__repr__

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **options: Unpack[SingleEnvOptions],
    ) -> None:
        """Make the worlds; `reset` starts their episodes.

        `max_episode_steps`, as passed by `gymnasium.make_vec`, limits episodes like a TimeLimit
        wrapper: the observation `time_left` does not depend on it. None or -1: no limit.
        """
        self.closed = True  # Gymnasium < 1.3 closes a refused environment when it is deleted
        self._mode = _autoreset_mode(autoreset_mode)
        self.num_envs = checked_count("num_envs", num_envs)
        self._make(self.num_envs, options)
        if self._mode is not AutoresetMode.DISABLED:
            self.array_env.check_keeps_step(
                "use SwarmVecEnv, vectorization_mode='sync', or autoreset_mode='Disabled'"
            )
        if max_episode_steps not in (None, -1):
            longest = checked_count("max_episode_steps", max_episode_steps)
            if self.array_env.config.step_on == "exchange":
                raise ConfigError(
                    f"max_episode_steps={longest}: under step_on='exchange' the length of an"
                    " episode is counted in ticks, not steps; use max_cycles instead"
                )
            self.max_cycles = min(self.max_cycles, longest)
        self.metadata = {**self.metadata, "autoreset_mode": self._mode}
        self.single_observation_space = self._joint_observations
        self.single_action_space = self._joint_actions
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.closed = False

    def reset(
        self, *, seed: Seeds = None, options: dict[str, object] | None = None
    ) -> tuple[Float32[Array, "rows numbers"], dict[str, object]]:
        """Reset all worlds; a seed fixes an episode and all later ones started without a seed.

        With the autoreset mode DISABLED, `options["reset_mask"]` chooses the worlds; other options
        are scenario parameters for these episodes.
        """
        numbers = dict(checked_options(options))
        chosen = self._chosen(numbers.pop("reset_mask", None))
        seeds = checked_seeds(seed, self.array_env.n_worlds)
        return self._begin([seeds[w] for w in chosen], numbers, chosen), self._infos()

    def step(
        self, actions: object
    ) -> tuple[
        Float32[Array, "rows numbers"],
        Float64[Array, " rows"],
        Bool[Array, " rows"],
        Bool[Array, " rows"],
        dict[str, object],
    ]:
        """Run one decision period; a refused action leaves the worlds unchanged.

        When the episodes have ended, NEXT_STEP resets in the next call and ignores its actions;
        SAME_STEP resets in the same call and returns the last results as `final_obs` and
        `final_info`; DISABLED requires a call of reset().
        """
        never = np.zeros(self.num_envs, np.bool_)
        if self._mode is AutoresetMode.NEXT_STEP and self._over.any():
            observations, infos = self.reset()
            return observations, np.zeros(self.num_envs), never, never.copy(), infos
        self.array_env.episodes.check_running(self.max_cycles)
        observations, rewards, _ = self._advance(actions)
        infos, truncated = self._infos(), self._over
        if self._mode is AutoresetMode.SAME_STEP and truncated.any():
            final = np.empty(self.num_envs, object)
            final[:] = list(observations)
            last = {"final_obs": final, "final_info": infos}
            observations, infos = self.reset()
            infos |= self._masked(last)
        return observations, self._joint(rewards), never, truncated, infos

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """Generator of the seeds of each world, as in single environments."""
        return tuple(self.array_env.episodes.generators)

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        sequences: list[Any] = [each.bit_generator.seed_seq for each in self.np_random]
        return tuple(each.entropy for each in sequences)

    def render(self) -> Any:  # noqa: ANN401 as in Gymnasium
        """Return a frame of its world (`ansi`: text) per row; ConfigError without a render mode."""
        return tuple(frame for frame in self._frames() for _ in range(self._rows_in_world))

    def close_extras(self, **kwargs: object) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    @property
    def _over(self) -> Bool[Array, " rows"]:
        """Whether the episode of each row has ended, by itself or at `max_episode_steps`."""
        env = self.array_env
        return self._of_rows(np.asarray(env.is_over | (env.episodes.steps >= self.max_cycles)))

    def _chosen(self, mask: object) -> list[int]:
        if mask is None:
            return list(range(self.array_env.n_worlds))
        chosen = np.asarray(mask)
        if chosen.dtype != np.bool_ or chosen.shape != (self.num_envs,):
            rows = "robots" if self.is_shared else "worlds"
            raise ConfigError(
                f"options['reset_mask']={shown(mask)}: must be a mask of {self.num_envs} {rows}"
            )
        if self._mode is not AutoresetMode.DISABLED and not chosen.all():
            raise ConfigError(
                "options['reset_mask']: worlds that reset themselves must stay in step, so none"
                " is reset alone; use autoreset_mode='Disabled', or reset all worlds"
            )
        by_world = chosen.reshape(-1, self._rows_in_world)
        worlds = by_world.all(axis=1)
        if (by_world.any(axis=1) != worlds).any():
            raise ConfigError("options['reset_mask']: the robots of a world are reset together")
        return np.flatnonzero(worlds).tolist()

    def _infos(self) -> dict[str, object]:
        return self._masked(self._joint_infos())

    def _masked(self, infos: Mapping[str, object]) -> dict[str, object]:
        """Return the infos with Gymnasium's masks of the worlds that have them: all worlds."""
        has = {f"_{name}": np.ones(self.num_envs, np.bool_) for name in infos}
        return {**infos, **has}


class LearnerVectorEnv(_SwarmVectorEnv):
    """Vector of `LearnerEnv`: in each world the first robot learns among team-mates.

    >>> LearnerVectorEnv(num_envs=3, scenario="near").action_space.shape
    (3, 2)
    """

    single_learner = True


class JointVectorEnv(_SwarmVectorEnv):
    """Vector of `JointEnv`: in each world one learner steers all robots.

    >>> JointVectorEnv(num_envs=3, scenario="near").action_space.shape
    (3, 10)
    """


class SharedVectorEnv(_SwarmVectorEnv):
    """Vector of robots, for parameter sharing: one policy acts for each robot that learns.

    Environment k is learner k % L of world k // L, as in `SwarmVecEnv`, where L robots of a world
    learn: all, unless `learners` selects some. `num_envs` is a multiple of L. Seeds are given per
    world, and the robots of a world are reset together.

    >>> SharedVectorEnv(num_envs=15, scenario="near").action_space.shape  # three worlds
    (15, 2)
    """

    is_shared = True


def _autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        known = ", ".join(repr(each.value) for each in AutoresetMode)
        raise ConfigError(f"autoreset_mode={mode!r}: must be one of {known}") from None
