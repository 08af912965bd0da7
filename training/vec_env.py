"""A stable-baselines3 vector environment whose environments are the robots of W worlds."""

from collections.abc import Iterable, Sequence
from typing import Any, Unpack

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.controllers import Controllers
from swarm_forage_env.envs.actions import as_array
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.episodes import checked_options, checked_seeds
from swarm_forage_env.envs.keywords import EnvOptions, RenderMode
from swarm_forage_env.envs.render import Frame, ShownEnv
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.viewer import check_render_mode
from swarm_forage_env.scenarios import ScenarioSource
from swarm_forage_env.worlds_on_cpu import Device

Infos = list[dict[str, Any]]


class SwarmVecEnv(ShownEnv, VecEnv):
    """W worlds of N robots as W * N environments: parameter sharing, one policy for all robots.

    Environment k is learner k % L of world k // L, where L robots of a world learn: all, unless
    `learners` selects some. The keywords are those of `parallel_env`, `render_mode` included.

    A world resets to the next seed of its sequence when its episode ends, all worlds together
    unless `stagger` is set. The last infos hold `terminal_observation`, `TimeLimit.truncated`
    (time-outs are bootstrapped, as foraging has no end) and the metrics that `parallel_env` logs
    for a robot, such as `round_trips`. Actions out of bounds and NaN raise a ConfigError; PPO
    clips its own actions.

    >>> env = SwarmVecEnv("near", n_worlds=4)
    >>> env.num_envs, len(env.reset())  # four worlds of five robots
    (20, 20)

    With `device="cuda"` the worlds run on a GPU, under the restrictions of `ArrayEnv`. Trainers of
    stable-baselines3 need NumPy: every step copies all actions to the GPU, and all observations
    and rewards back, and makes a dictionary for each row on the CPU. Thousands of worlds pay off
    with a trainer that stays on the GPU: `training.ppo_learner`, TorchRL.

    A model trained on it stores the keywords: `swarm-forage evaluate es1 sb3:model.zip` runs the
    file of `model.save("model.zip")`.
    """

    metadata: dict[str, Any]
    render_mode: RenderMode | None = None  # VecEnv reads it before `_show` sets it

    def __init__(  # noqa: PLR0913 keywords of the public API
        self,
        scenario: ScenarioSource = "es1",
        n_worlds: int = 8,
        controller: Controllers | None = None,
        seed: int | Sequence[int] = 0,
        stagger: bool = False,
        render_mode: RenderMode | None = None,
        device: Device = "cpu",
        **options: Unpack[EnvOptions],
    ) -> None:
        """Make the worlds, and call the method `seed` with `seed`.

        Args:
            scenario: A name, a TOML file or a `Scenario`.
            n_worlds: Number of worlds; each adds a row per learner.
            controller: Controller of the layers that are not learned.
            seed: Seed of the sequences of episodes: a single one, or one for each world.
            stagger: The first episodes end at different times.
            render_mode: As in `parallel_env`.
            device: `cpu` or `cuda`.
            **options: The fields of `EnvConfig`, and parameters of the scenario.
        """
        check_render_mode(render_mode)
        self.env = env = ArrayEnv(scenario, n_worlds, controller, stagger, device, **options)
        super().__init__(n_worlds * len(env.learners), env.observation_space, env.action_space)
        self._show(env, render_mode)
        decisions_per_s = max(1, round(1.0 / float(self.scenario.tick * env.config.period)))
        self.metadata["render_fps"] = decisions_per_s
        self._next: Float32[Array, "rows numbers"] | None = None
        self.seed(seed)

    def seed(self, seed: int | Sequence[int] | None = None) -> Sequence[int | None]:
        """Seed the sequences from which resets draw the seeds of episodes, also of the first ones.

        From a single seed, world w takes seed + w. A world begins with the episode that in
        `ArrayEnv` follows the one of its seed, so that a training meets none of the small seeds
        that `evaluate` uses. A model of stable-baselines3 passes its `seed` on.
        """
        seeds = checked_seeds(seed, self.env.n_worlds)
        self.env.episodes.seed(seeds)
        return [own for own in seeds for _ in self.env.learners]

    def set_options(self, options: object = None) -> None:
        """Set parameters of the scenario for the episodes of the next reset, in all worlds."""
        numbers = checked_options(options)
        self.env.episodes.scenario_under(numbers)
        super().set_options(dict(numbers))

    @property
    def max_episode_steps(self) -> int:
        """Number of decisions in an episode, under the usual name."""
        return self.max_cycles

    @property
    def np_random(self) -> tuple[np.random.Generator, ...]:
        """Random generators of the worlds' seeds."""
        return tuple(self.env.episodes.generators)

    def reset(self) -> Float32[Array, "rows numbers"]:
        """Reset every world and return the observation of every learner."""
        self.reset_infos: Infos = [{} for _ in range(self.num_envs)]
        observations, _ = self.env.reset(options=self._options[0])
        self._reset_options()
        self._follow()
        return self.env.memory.read(observations).reshape(self.num_envs, -1)

    def step_async(self, actions: Array) -> None:
        """Store the actions of all learners; ConfigError if they do not fit the action space."""
        self._next = self.env.actions.rows(as_array(actions))

    def step_wait(
        self,
    ) -> tuple[Float32[Array, "rows numbers"], Float32[Array, " rows"], Array, Infos]:
        """Run one decision period and return observations, rewards, dones and infos."""
        if self._next is None:
            raise ConfigError("step_wait() without an action: call step_async(actions) first")
        step, on_cpu = self.env.advance(self._next), self.env.memory.read
        observations, rewards, over = (on_cpu(step[k]) for k in (0, 1, 3))
        self._next = None
        self._follow()
        unshaped = on_cpu(step[4]["unshaped_reward"]).ravel().tolist()
        infos: Infos = [{"unshaped_reward": each} for each in unshaped]
        dones, rows = np.repeat(over, len(self.env.learners)), (self.num_envs, -1)
        if over.any():
            last, log = observations.reshape(rows), on_cpu(self.env.log()).reshape(rows)
            for row in np.flatnonzero(dones).tolist():
                infos[row] |= {"terminal_observation": last[row], "TimeLimit.truncated": True}
                infos[row] |= zip(self.env.infos, log[row].tolist(), strict=True)
                infos[row] |= self.env.episodes.drawn_in(row // len(self.env.learners))
            observations = on_cpu(self.env.reset(worlds=over)[0])
        return observations.reshape(rows), rewards.ravel().astype(np.float32), dones, infos

    def get_images(self) -> Sequence[Frame | None]:
        """Return the frame of each world, once for each of its learners."""
        return [frame for frame in self._drawn() for _ in self.env.learners]

    def render(self, mode: str | None = None) -> Frame | None:
        """Return the frame of the first world; None if it is on the screen."""
        return self._drawn()[0]

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[object]:
        """Return an attribute, once for each of the selected environments."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(
        self, attr_name: str, value: object, indices: int | Iterable[int] | None = None
    ) -> None:
        """Raise ConfigError: the options of the worlds are fixed when they are made."""
        raise ConfigError(
            f"set_attr('{attr_name}'): the environments share one block of worlds, whose options"
            f" are fixed; make a new one with {attr_name}={value!r}"
        )

    def env_method(
        self,
        method_name: str,
        *method_args: object,
        indices: int | Iterable[int] | None = None,
        **method_kwargs: object,
    ) -> list[object]:
        """Call a method once, and return its result once for each of the selected environments."""
        result = getattr(self, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type, indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """Return False for each environment: none is wrapped individually."""
        return [False for _ in self._get_indices(indices)]

    def _follow(self) -> None:
        if self.render_mode == "human":
            self.env.download()
        self._screen.follow()

    def _drawn(self) -> list[Frame | None]:
        self.env.download()
        return [None if isinstance(each, str) else each for each in self._screen.draw()]
