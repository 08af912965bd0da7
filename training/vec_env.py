"""A stable-baselines3 vector environment whose environments are the robots of W worlds."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.actions import Actions, is_within
from swarm_forage_env.envs.make import make_array_env
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Controller
from swarm_forage_env.parameters import Count, Part, validated
from swarm_forage_env.random_streams import checked_seed

Infos = list[dict[str, Any]]


class SharedAttributesVecEnv(VecEnv):
    """A vector environment whose environments share all attributes and methods."""

    def close(self) -> None:
        """Close the environments; there is nothing to release."""

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """Return an attribute, once for each environment asked for."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(
        self,
        attr_name: str,
        value: Any,  # noqa: ANN401 whatever the attribute holds
        indices: int | Iterable[int] | None = None,
    ) -> None:
        """Set an attribute of the vector environment."""
        setattr(self, attr_name, value)

    def env_method(
        self,
        method_name: str,
        *method_args: Any,  # noqa: ANN401 the method's
        indices: int | Iterable[int] | None = None,
        **method_kwargs: Any,  # noqa: ANN401 the method's
    ) -> list[Any]:
        """Call a method once, and return its result once for each environment asked for."""
        result = getattr(self, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self,
        wrapper_class: Any,  # noqa: ANN401 a type
        indices: int | Iterable[int] | None = None,
    ) -> list[bool]:
        """Return False for each environment: none is wrapped individually."""
        return [False for _ in self._get_indices(indices)]


class SwarmVecEnv(SharedAttributesVecEnv):
    """W worlds of N robots as W * N environments: parameter sharing, one policy for all robots.

    Environment k is robot k % N of world k // N. Options are those of `parallel_env`: what is
    learned (`learn`, `residual`, `reward`, `shaping`, `discount`, `decision_period`, `physics`,
    `max_cycles`) and numbers of the scenario by dotted name.

    All worlds run out of time together and start anew from the next seeds of the sequence that
    `seed` began. The last infos hold `terminal_observation`, `TimeLimit.truncated` (time-outs
    are bootstrapped, as foraging has no end) and what `parallel_env` logs of a robot, as
    `round_trips`. Actions out of bounds and NaN are refused with a ConfigError: PPO clips its
    own.
    """

    def __init__(
        self,
        scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
        n_worlds: int = 8,
        controller: str | Controller | None = None,
        seed: int = 0,
        **options: Any,  # noqa: ANN401 checked by EnvConfig and by the scenario
    ) -> None:
        """Make the worlds; `reset` draws their seeds from a generator seeded by `seed`."""
        _ = validated(_WorldCount, {"n_worlds": n_worlds})
        self.env = make_array_env(range(n_worlds), options, scenario, controller)
        self.scenario = self.env.world.scenario
        self.max_cycles = self.env.n_cycles
        self.observation_layout = self.env.observation_layout
        self.action_layout = self.env.action_layout
        self.render_mode = None
        self._n_worlds = n_worlds
        rows = self.env.world.robots.size
        self._space = self.action_layout.box()
        self._actions = Actions([f"environment {k}" for k in range(rows)], self.action_layout)
        self._next: Float32[Array, "rows numbers"] | None = None
        self._cycles = 0
        super().__init__(rows, self.observation_layout.box(), self._space)
        self.seed(seed)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the generator from which resets draw the seeds of the worlds."""
        checked = None if seed is None else checked_seed(seed)
        self._rng = np.random.default_rng(checked)
        return [checked] * self.num_envs

    def reset(self) -> Float32[Array, "rows numbers"]:
        """Reset every world and return the observation of every robot."""
        self._cycles = 0
        self.reset_infos: Infos = [{} for _ in range(self.num_envs)]
        seeds = self._rng.integers(2**63, size=self._n_worlds)
        return np.asarray(self.env.reset([int(seed) for seed in seeds]))

    def step_async(self, actions: Float32[Array, "rows numbers"]) -> None:
        """Store the actions of all robots; ConfigError if they do not fit the action space."""
        given = np.asarray(actions)
        if given.shape != (self.num_envs, *self._space.shape):
            raise ConfigError(
                f"actions of shape {given.shape}: must be {(self.num_envs, *self._space.shape)}"
            )
        if given.dtype != np.float32 or not is_within(given, self._space.low, self._space.high):
            given = self._actions.matrix(
                {f"environment {k}": action for k, action in enumerate(given)}
            )
        self._next = given

    def step_wait(
        self,
    ) -> tuple[Float32[Array, "rows numbers"], Float32[Array, " rows"], Array, Infos]:
        """Run one decision period and return observations, rewards, dones and infos."""
        if self._next is None:
            raise ConfigError("step_wait() without an action: call step_async(actions) first")
        observations, rewards = self.env.step(self._next)
        self._next = None
        self._cycles += 1
        over = self._cycles >= self.max_cycles
        infos: Infos = [{} for _ in range(self.num_envs)]
        if over:
            for info, last, log in zip(infos, observations, self.env.log(), strict=True):
                info["terminal_observation"] = last
                info["TimeLimit.truncated"] = True
                info |= zip(self.env.infos, log, strict=True)
            observations = self.reset()
        done = np.full(self.num_envs, over)
        return observations, rewards.astype(np.float32), done, infos


class _WorldCount(Part):
    """Validation of the number of worlds of a vector environment."""

    n_worlds: Count
