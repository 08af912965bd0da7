"""ArrayEnv, the batch API: W worlds of N robots as arrays. Every API in this folder wraps it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Discrete

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int64
from swarm_forage_env.envs.actions import ActionForm, Actions
from swarm_forage_env.envs.config import chosen_robots, n_steps
from swarm_forage_env.envs.make import Parts, checked_parts
from swarm_forage_env.envs.observations import (
    LAYER,
    Moment,
    Normaliser,
    Observer,
    normalised,
    stacked,
)
from swarm_forage_env.envs.rewards import EarnedInTick, shaping
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import CORRECT, REPLACE, Controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import Count, Part, validated
from swarm_forage_env.random_streams import checked_seed, drawn_seed
from swarm_forage_env.spaces import Layout

Seeds = int | Sequence[int | None] | None
"""One seed, for worlds seed, seed + 1 and so on; or one for each world."""

Infos = dict[str, Array]
"""Numbers that are no observation, by name: of shape (worlds, learners) or (worlds,)."""

SHARE_GONE = "share_gone"


class ArrayEnv:
    """W worlds side by side, in each of which some robots learn: arrays in, arrays out.

        env = ArrayEnv("es1", n_worlds=64, threads=2)
        observations, infos = env.reset(seed=0)              # (64, 10, numbers)
        observations, rewards, terminated, truncated, infos = env.step(actions)
        observations, infos = env.reset(worlds=truncated)    # those start anew

    The first axis is the world, the second the learner, in the order of `learners`. A world equals
    the same world alone, bit for bit, and the number of threads changes nothing. Nobody dies:
    `terminated` is False everywhere, and a world is truncated after `max_cycles` steps. It must
    be reset then, by a mask or by numbers of worlds; the others go on.

    With a decision period of k ticks an action is held for k ticks, and the rewards of all k
    are added up. A weight g held so applies to every exchange that ends in these ticks, while
    the observation shows the last tick only: for `learn="weighting"` k = 1 is what the
    hand-written rules have.
    """

    def __init__(
        self,
        scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
        n_worlds: int = 1,
        controller: str | Controller | None = None,
        stagger: bool = False,
        **options: Any,  # noqa: ANN401 as parallel_env
    ) -> None:
        """Make the worlds under the keywords of `parallel_env`; `reset` starts their episodes.

        With `stagger` the first episodes end one after the other, evenly spread over an
        episode's time, so that a batch shows all phases of an episode at once.
        """
        self.n_worlds = validated(_Worlds, {"n_worlds": n_worlds}).n_worlds
        parts = checked_parts(scenario, controller, options)
        self.config, self.task, self._is_staggered = parts.config, parts.task, stagger
        self.decision_period: int = parts.config.decision_period or 1
        self.max_cycles = n_steps(parts.scenario, parts.config)
        self._start(parts)
        self._describe(parts)
        self.generators = [np.random.default_rng() for _ in range(self.n_worlds)]
        self._steps: Int64[Array, " worlds"] = np.zeros(self.n_worlds, np.int64)
        self._ends: Int64[Array, " worlds"] = np.zeros(self.n_worlds, np.int64)

    def _start(self, parts: Parts) -> None:
        """Make the loop, and mark the layers of the learners as theirs."""
        config, task = parts.config, parts.task
        self._policy = task.policies[config.learn]
        no_layers = task.no_layers if config.learn == "everything" else None
        self.loop = Loop(
            parts.scenario,
            no_layers or parts.controller,
            range(self.n_worlds),
            config.physics,
            config.threads,
        )
        self.world = self.loop.world
        n_robots = self.world.n_robots
        self.agents = [f"{task.agent}_{k}" for k in range(n_robots)]
        self._learns = np.array(chosen_robots(config.learners, self.agents))
        self.learners = [self.agents[k] for k in self._learns]
        action = self.world.robots["action"]
        for layer in self._policy.replaces:
            is_residual = config.residual and layer == "motion"
            action[layer][:, self._learns] = CORRECT if is_residual else REPLACE
        self._potential = task.potential(self.world)
        self._earned = EarnedInTick(self.world, task, config.reward)

    def _describe(self, parts: Parts) -> None:
        """Make the spaces, and what writes observations and the state."""
        config, policy = parts.config, self._policy
        ticks = max(parts.scenario.n_ticks, self.max_cycles * self.decision_period)
        bounds = self.task.bounds(
            parts.scenario, ticks, getattr(parts.controller, "message_path", 0.0)
        )
        shown = policy.layout(bounds)
        self._observer = Observer(
            policy, config.observation, shown, parts.scenario, self.agents, config.normalise
        )
        is_plain = config.observation == LAYER and not config.normalise and config.stack == 1
        self.observation_layout: Layout = (
            shown if is_plain else stacked(self._observer.layout, config.stack)
        )
        self.observation_space: Box = self.observation_layout.box()
        self._form = ActionForm(self.task, policy, config)
        self.action_layout = self._form.layout
        self.action_space: Box | Discrete[Any] = self._form.space
        self.action_shape = self._form.shape
        self.actions = Actions(_names(self.learners, self.n_worlds), self._form)
        self.truth = self.task.global_state(self.world, self.loop.controller, self.agents, bounds)
        self._state = Normaliser(self.truth.layout) if config.normalise else None
        self.state_layout: Layout = (
            normalised(self.truth.layout) if config.normalise else self.truth.layout
        )
        self.state_space: Box = self.state_layout.box()
        n_rows, n_robots = self.n_worlds, self.world.n_robots
        self._last_action = np.zeros((n_rows, n_robots, len(policy.action)), np.float32)
        n_frames = (n_rows, n_robots, config.stack, len(self._observer.layout))
        self._frames = np.zeros(n_frames, np.float32) if config.stack > 1 else None

    @property
    def infos(self) -> tuple[str, ...]:
        """The names of what `log` tells of each robot."""
        names: tuple[str, ...] = self.truth.infos
        return names

    def reset(
        self,
        seed: Seeds = None,
        worlds: Any = None,  # noqa: ANN401 a mask, or numbers
        options: Mapping[str, Any] | None = None,
    ) -> tuple[Float32[Array, "worlds learners numbers"], Infos]:
        """Start worlds anew, all unless `worlds` is a mask or numbers of some; observe all.

        A seed fixes an episode and all that follow without one: one for the first of these
        worlds, whose others take the next whole numbers, or one for each of them.
        """
        chosen = self._numbers_of(worlds)
        seeds = self._world_seeds(seed, chosen)
        self.loop.reset(seeds)
        is_first = not self._ends.any()
        self._steps[chosen] = 0
        self._ends[chosen] = self.max_cycles
        if is_first and self._is_staggered:
            share = np.arange(1, self.n_worlds + 1) / self.n_worlds
            self._ends[:] = np.maximum(1, np.ceil(share * self.max_cycles))
        self._last_action[chosen] = 0.0
        return self._observe(fresh=chosen), self._infos(
            np.zeros((self.n_worlds, len(self.learners)))
        )

    def step(
        self,
        actions: Any,  # noqa: ANN401 checked against the action space
    ) -> tuple[
        Float32[Array, "worlds learners numbers"],
        Float64[Array, "worlds learners"],
        Bool[Array, " worlds"],
        Bool[Array, " worlds"],
        Infos,
    ]:
        """One decision period; observations, rewards, terminated, truncated, infos.

        `actions` have the shape (worlds, learners, numbers), or (worlds, learners) where they are
        choices. A refused action leaves everything as it was.
        """
        given = np.asarray(actions)
        if given.shape[:2] != (self.n_worlds, len(self.learners)):
            raise ConfigError(
                f"actions of shape {given.shape}: must be"
                f" {(self.n_worlds, len(self.learners), *self.action_shape)}"
            )
        return self.advance(self.actions.rows(given.reshape(-1, *given.shape[2:])))

    def advance(
        self, raw: Float32[Array, "rows numbers"]
    ) -> tuple[
        Float32[Array, "worlds learners numbers"],
        Float64[Array, "worlds learners"],
        Bool[Array, " worlds"],
        Bool[Array, " worlds"],
        Infos,
    ]:
        """`step` with what the layers take, as `actions` made it of the actions of all learners."""
        self._check_running()
        action = raw.reshape(self.n_worlds, len(self.learners), -1)
        self._policy.act(self.world, self.loop.controller, self._learns, action)
        self._last_action[:, self._learns] = action
        before = self._potential() if self.config.shaping > 0.0 else None
        earned = self._run()
        unshaped = self._earned.credit(earned)
        rewards = unshaped
        if before is not None:
            added = shaping(before, self._potential(), self.config.discount, self.config.shaping)
            rewards = self._earned.credit(earned + added.reshape(earned.shape))
        self._steps += 1
        return (
            self._observe(),
            self._of_learners(rewards),
            np.zeros(self.n_worlds, np.bool_),
            self.is_over,
            self._infos(self._of_learners(unshaped)),
        )

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """The episode of each world has ended: it must be reset."""
        return np.asarray((self._ends > 0) & (self._steps >= self._ends))

    @property
    def share_gone(self) -> Float64[Array, " worlds"]:
        """Share of the episode that each world has behind it."""
        return self._steps / np.maximum(self._ends, 1)

    def state(self) -> Float32[Array, "worlds numbers"]:
        """The truth about every world, as `state_layout` says; for centralised critics."""
        found: Float32[Array, "worlds numbers"] = self.truth.state(self.share_gone)
        if self._state is not None:
            self._state(found)
        return found

    def log(self) -> Float64[Array, "worlds learners infos"]:
        """What is logged of each learner, in the order of `infos`; worked out when asked for."""
        found: Array = self.truth.log()
        return np.asarray(self._of_learners(found.reshape(self.n_worlds, self.world.n_robots, -1)))

    def _run(self) -> Float64[Array, "worlds robots"]:
        """What every robot earned in the ticks of a decision period."""
        earned = np.zeros((self.n_worlds, self.world.n_robots))
        for _ in range(self.decision_period):
            self._earned.remember()
            self.loop.step()
            earned += self._earned()
        return earned

    def _observe(
        self, fresh: Int64[Array, " worlds"] | None = None
    ) -> Float32[Array, "worlds learners numbers"]:
        """What every learner observes; worlds that are `fresh` have no earlier frames."""
        minds = self.loop.controller.minds
        moment = Moment(
            self.world.robots,
            self.world.worlds,
            minds["estimator"] if "estimator" in (minds.dtype.names or ()) else None,
            1.0 - self.share_gone,
            self._last_action,
        )
        seen = self._observer(self.world, self.loop.controller, moment)
        if self._frames is not None:
            if fresh is None:
                self._frames[:, :, :-1] = self._frames[:, :, 1:]
                self._frames[:, :, -1] = seen
            else:
                self._frames[fresh] = seen[fresh, :, None]
            seen = self._frames.reshape(*seen.shape[:2], -1).copy()
        return self._of_learners(seen)

    def _of_learners(self, of_robots: Array) -> Array:
        """The columns of those that learn."""
        is_all = len(self.learners) == len(self.agents)
        return of_robots if is_all else of_robots[:, self._learns]

    def _infos(self, unshaped: Float64[Array, "worlds learners"]) -> Infos:
        return {"unshaped_reward": unshaped}

    def _check_running(self) -> None:
        if not self._ends.all():
            raise ResetNeeded("the episode has not begun: call reset() first")
        if self.is_over.any():
            (which, *_) = np.flatnonzero(self.is_over)
            where = "" if self.n_worlds == 1 else f" of world {which}"
            raise ResetNeeded(
                f"step after the end{where}, at {self._steps[which]} cycles: call reset() first"
            )

    def _numbers_of(self, worlds: Any) -> Int64[Array, " chosen"]:  # noqa: ANN401 whatever was given
        """The numbers of the chosen worlds; ConfigError for what names none."""
        if worlds is None:
            return np.arange(self.n_worlds)
        found = np.asarray(worlds)
        if found.dtype == np.bool_ and found.shape == (self.n_worlds,):
            return np.flatnonzero(found)
        is_number = found.dtype.kind in "iu" and found.ndim == 1
        if is_number and ((found >= 0) & (found < self.n_worlds)).all():
            return np.unique(found).astype(np.int64)
        raise ConfigError(
            f"worlds={worlds!r}: must be a mask of {self.n_worlds}, or numbers from 0 to"
            f" {self.n_worlds - 1}"
        )

    def _world_seeds(self, seed: Seeds, chosen: Int64[Array, " chosen"]) -> list[int]:
        """A seed for each of these worlds, from those given or from its sequence."""
        given = checked_seeds(seed, len(chosen))
        found = []
        for world, own in zip(chosen, given, strict=True):
            if own is not None:
                self.generators[world] = np.random.default_rng(own)
            found.append(drawn_seed(self.generators[world]) if own is None else own)
        return found


class _Worlds(Part):
    """Validation of the number of worlds."""

    n_worlds: Count


def checked_seeds(seed: Seeds, n: int) -> Sequence[int | None]:
    """A checked seed or None for each of n worlds, before anything is changed."""
    if seed is None:
        return [None] * n
    if not isinstance(seed, Sequence | np.ndarray) or isinstance(seed, str):
        first = checked_seed(seed)
        return [checked_seed(first + world) for world in range(n)]
    if len(seed) != n:
        raise ConfigError(f"seed={seed!r}: must be {n}, one for each world")
    return [None if own is None else checked_seed(own) for own in seed]


def _names(learners: Sequence[str], n_worlds: int) -> list[str]:
    """The names of all learners, in the order of the rows."""
    if n_worlds == 1:
        return list(learners)
    return [f"{name} of world {w}" for w in range(n_worlds) for name in learners]
