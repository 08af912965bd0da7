"""Worlds in one block of arrays, as Gymnasium vector environments: one learner in each, or all."""

from typing import Any, ClassVar

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.envs.episodes import Seeds, checked_options, checked_seeds
from swarm_forage_env.envs.gymnasium_core import JointEnvCore
from swarm_forage_env.envs.gymnasium_env import METADATA
from swarm_forage_env.envs.render import render_modes
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.task import World

VECTOR_METADATA: dict[str, Any] = {**METADATA, "autoreset_mode": AutoresetMode.NEXT_STEP}


class _SwarmVectorEnv(VectorEnv[Any, Any, Any]):
    """Worlds side by side, equal to so many single environments, step for step and bit for bit.

    All episodes have the same length, so all worlds are truncated and start anew together.
    """

    metadata: dict[str, Any] = VECTOR_METADATA
    single_learner: ClassVar[bool] = False

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **options: Any,  # noqa: ANN401 as parallel_env
    ) -> None:
        """Make the worlds; `reset` starts their episodes.

        `max_episode_steps`, which `gymnasium.make_vec` hands on, ends episodes that `max_cycles`
        or the scenario's time would let go on, as a TimeLimit does; -1 stands for none.
        """
        self._mode = _autoreset_mode(autoreset_mode)
        self.num_envs = _count("num_envs", num_envs)
        self._core = core = JointEnvCore(self.num_envs, self.single_learner, options)
        if max_episode_steps not in (None, -1):
            core.env.max_cycles = min(
                core.env.max_cycles, _count("max_episode_steps", max_episode_steps)
            )
        self.render_mode = core.render_mode
        self.metadata = {
            **self.metadata,
            "render_modes": render_modes(self.scenario),
            "autoreset_mode": self._mode,
        }
        self.max_cycles = core.env.max_cycles
        self.observation_layout = core.env.observation_layout
        self.action_layout = core.env.action_layout
        self.single_observation_space = core.observation_space
        self.single_action_space = core.action_space
        self.observation_space = batch_space(core.observation_space, self.num_envs)
        self.action_space = batch_space(core.action_space, self.num_envs)

    @property
    def world(self) -> World:
        """The worlds of the robots: their records are the truth."""
        return self._core.env.world

    @property
    def scenario(self) -> Any:  # noqa: ANN401 of any task
        """The scenario of the first world's episode."""
        return self.world.scenario

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32[Array, "worlds numbers"], dict[str, Any]]:
        """Start every world anew; a seed fixes its episode and all that follow without one.

        With the autoreset mode DISABLED `options["reset_mask"]` chooses some of them; the other
        options are numbers of the scenario for these episodes.
        """
        given = dict(checked_options(options))
        chosen = self._chosen(given.pop("reset_mask", None))
        seeds = checked_seeds(seed, self.num_envs)
        return self._core.reset([seeds[w] for w in chosen], given, chosen), self._infos()

    def step(
        self,
        actions: Any,  # noqa: ANN401 whatever was passed
    ) -> tuple[
        Float32[Array, "worlds numbers"],
        Float64[Array, " worlds"],
        Bool[Array, " worlds"],
        Bool[Array, " worlds"],
        dict[str, Any],
    ]:
        """One decision period; a refused action leaves everything as it was.

        After the end of the episodes NEXT_STEP takes the next call, whatever its actions, for a
        reset; SAME_STEP has reset already, and shows what came last as `final_obs` and
        `final_info`; DISABLED wants a call of reset().
        """
        never = np.zeros(self.num_envs, np.bool_)
        if self._core.over and self._mode is AutoresetMode.NEXT_STEP:
            observations, infos = self.reset()
            return observations, np.zeros(self.num_envs), never, never.copy(), infos
        observations, rewards, truncated = self._core.step(actions)
        infos, over = self._infos(), self._core.over
        if over and self._mode is AutoresetMode.SAME_STEP:
            last = {"final_obs": _unbatched(observations), "final_info": infos}
            observations, infos = self.reset()
            infos |= self._masked(last)
        return observations, self._core.joint(rewards), never, truncated, infos

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The generator of each world's seeds, as of single environments side by side."""
        return tuple(self._core.env.episodes.generators)

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seed of each of them."""
        sequences: list[Any] = [each.bit_generator.seed_seq for each in self.np_random]
        return tuple(each.entropy for each in sequences)

    def snapshot(self) -> Any:  # noqa: ANN401 for `restore` alone
        """All that the next steps depend on: to be restored any number of times, and pickled."""
        return self._core.snapshot()

    def restore(self, snapshot: Any) -> None:  # noqa: ANN401 of `snapshot`
        """Go on as when the snapshot was taken, bit for bit.

        ConfigError if it is of an environment of other options.
        """
        self._core.restore(snapshot)

    def render(self) -> Any:  # noqa: ANN401 as Gymnasium has it
        """A frame of each world, as rows of red, green and blue.

        ConfigError where no `render_mode` was given.
        """
        return tuple(self._core.render())

    def _repr_html_(self) -> str:
        """A picture of this moment and a table, for notebooks."""
        return self._core.html(type(self).__name__)

    def close_extras(self, **kwargs: Any) -> None:  # noqa: ANN401 as Gymnasium has it
        """Close the window, if there is one."""
        self._core.close()

    def _chosen(self, mask: Any) -> list[int]:  # noqa: ANN401 whatever was passed
        """The worlds of a mask; ConfigError for one that does not fit."""
        if mask is None:
            return list(range(self.num_envs))
        found = np.asarray(mask)
        if found.dtype != np.bool_ or found.shape != (self.num_envs,):
            raise ConfigError(
                f"options['reset_mask']={mask!r}: must be a mask of {self.num_envs} worlds"
            )
        if self._mode is not AutoresetMode.DISABLED and not found.all():
            raise ConfigError(
                "options['reset_mask']: worlds that reset by themselves keep in step; take"
                " autoreset_mode='Disabled', or reset all of them"
            )
        return np.flatnonzero(found).tolist()

    def _infos(self) -> dict[str, Any]:
        return self._masked(self._core.infos())

    def _masked(self, infos: dict[str, Any]) -> dict[str, Any]:
        """Infos and, as Gymnasium wants, who has each of them: every world."""
        has = {f"_{name}": np.ones(self.num_envs, np.bool_) for name in infos}
        return infos | has


class LearnerVectorEnv(_SwarmVectorEnv):
    """`LearnerEnv` side by side: in each world the first robot learns among team-mates."""

    single_learner = True


class JointVectorEnv(_SwarmVectorEnv):
    """`JointEnv` side by side: in each world one learner steers all robots."""


def _count(name: str, value: Any) -> int:  # noqa: ANN401 whatever was passed
    if isinstance(value, int | np.integer) and not isinstance(value, bool) and value >= 1:
        return int(value)
    raise ConfigError(f"{name}={value!r}: must be a whole number, at least 1")


def _autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        known = ", ".join(repr(each.value) for each in AutoresetMode)
        raise ConfigError(f"autoreset_mode={mode!r}: must be one of {known}") from None


def _unbatched(observations: Float32[Array, "worlds numbers"]) -> Array:
    """One object for each world, as Gymnasium keeps final observations."""
    each = np.empty(len(observations), object)
    each[:] = list(observations)
    return each
