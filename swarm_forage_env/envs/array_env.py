"""ArrayEnv, the batch API: W worlds of N robots as arrays. Every API in this folder wraps it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int64
from swarm_forage_env.envs.actions import Actions, as_array
from swarm_forage_env.envs.config import chosen_robots, n_steps
from swarm_forage_env.envs.episodes import Episodes, Seeds, checked_options, parts_of
from swarm_forage_env.envs.make import Parts, checked_parts
from swarm_forage_env.envs.notebook import html_of, title_of
from swarm_forage_env.envs.observations import Normaliser, normalised
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.envs.rewards import EarnedInTick, add_shaping
from swarm_forage_env.envs.stepping import Exchanges, Stepper, Ticks
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import CORRECT, REPLACE
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import Count, Part, validated
from swarm_forage_env.policy_interface import Index
from swarm_forage_env.spaces import Layout, widest
from swarm_forage_env.task import World

Infos = dict[str, Array]
"""Numbers that are no observation, by name: of shape (worlds, learners) or (worlds,)."""

Step = tuple[
    Float32[Array, "worlds learners numbers"],
    Float64[Array, "worlds learners"],
    Bool[Array, " worlds"],
    Bool[Array, " worlds"],
    Infos,
]
"""Observations, rewards, terminated, truncated, infos."""


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
    hand-written rules have. With `step_on="exchange"` a step ends where an exchange of a learner
    does, in each world for itself; `infos["acts"]` tells whose next action counts.
    """

    def __init__(
        self,
        scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
        n_worlds: int = 1,
        controller: Any = None,  # noqa: ANN401 a name, a controller, or one for each robot
        stagger: bool = False,
        **options: Any,  # noqa: ANN401 as parallel_env
    ) -> None:
        """Make the worlds under the keywords of `parallel_env`; `reset` starts their episodes.

        With `stagger` the first episodes end one after the other, evenly spread over an
        episode's time, so that a batch shows all phases of an episode at once.
        """
        self._made_by = scenario, n_worlds, controller, stagger, options
        self.n_worlds = validated(_Worlds, {"n_worlds": n_worlds}).n_worlds
        parts = checked_parts(scenario, controller, options)
        self.config, self.task, self._is_staggered = parts.config, parts.task, stagger
        self.policy = parts.task.policies[parts.config.learn]
        self.max_cycles = n_steps(parts.scenario, parts.config)
        self.loop = self._made_loop(parts)
        self.agents = self.task.agents(self.world.n_robots)
        robots = chosen_robots(parts.config.learners, self.agents)
        self.learners = [self.agents[robot] for robot in robots]
        is_all = len(robots) == len(self.agents)
        self.learner_numbers: Int64[Array, " learners"] = np.array(robots, np.int64)
        """The numbers of the robots that learn."""
        self._learns: Index = slice(None) if is_all else self.learner_numbers
        self._hand_over()
        n_numbers = len(self.policy.action)
        self._last_action = np.zeros((*self.world.robots.shape, n_numbers), np.float32)
        self._potential = self.task.potential(self.world)
        self._earned = EarnedInTick(self.world, self.task, parts.config.reward)
        self.episodes = Episodes(self.loop, parts.scenario, parts.config.randomise)
        self._stepper = self._made_stepper()
        self._describe()

    @property
    def world(self) -> World:
        """The worlds of the robots: their records are the truth."""
        return self.loop.world

    @property
    def infos(self) -> tuple[str, ...]:
        """The names of what `log` tells of each robot."""
        names: tuple[str, ...] = self.truth.infos
        return names

    @property
    def robot_steps(self) -> int:
        """Control ticks of the learners of all worlds, since the environment was made."""
        return self._stepper.ticks * len(self.learners)

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """The episode of each world has ended: it must be reset."""
        return self.episodes.is_over

    def reset(
        self,
        seed: Seeds = None,
        worlds: Any = None,  # noqa: ANN401 a mask, or numbers
        options: Mapping[str, Any] | None = None,
    ) -> tuple[Float32[Array, "worlds learners numbers"], Infos]:
        """Start worlds anew, all unless `worlds` is a mask or numbers of some; observe all.

        A seed fixes an episode and all that follow without one: one for the first of these
        worlds, whose others take the next whole numbers, or one for each of them. `options` are
        numbers of the scenario for these episodes, by dotted name.
        """
        fresh = self.begin(seed, worlds, options)
        nothing = np.zeros((self.n_worlds, len(self.learners)))
        return self._observe(fresh), self._infos(nothing)

    def begin(
        self,
        seed: Seeds = None,
        worlds: Any = None,  # noqa: ANN401 a mask, or numbers
        options: Mapping[str, Any] | None = None,
    ) -> Int64[Array, " worlds"]:
        """`reset` without a look at what is observed: the numbers of the worlds that are new."""
        is_first = not self.episodes.ends.any()
        fresh = self.episodes.begin(seed, worlds, checked_options(options), self.max_cycles)
        if is_first and self._is_staggered:
            self.episodes.stagger()
        self._last_action[fresh] = 0.0
        return fresh

    def step(self, actions: Any) -> Step:  # noqa: ANN401 checked against the action space
        """One decision; observations, rewards, terminated, truncated, infos.

        `actions` have the shape (worlds, learners, numbers), or (worlds, learners) where they are
        choices. A refused action leaves everything as it was.
        """
        given = as_array(actions)
        if given.shape[:2] != (self.n_worlds, len(self.learners)):
            raise ConfigError(
                f"actions of shape {given.shape}: must be"
                f" {(self.n_worlds, len(self.learners), *self.action_shape)}"
            )
        return self.advance(self.actions.rows(given.reshape(-1, *given.shape[2:])))

    def advance(self, raw: Float32[Array, "rows numbers"]) -> Step:
        """`step` with what the layers take, as `actions` made it of the actions of all learners."""
        self.episodes.check_running()
        action = raw.reshape(self.n_worlds, len(self.learners), -1)
        self._act(self.world, self.loop.controller.minds, self._learns, action)
        self._last_action[:, self._learns] = action
        before = self._potential() if self.config.shaping > 0.0 else None
        earned = self._stepper.run(self._earned)
        unshaped = self._earned.credit(earned)
        rewards = unshaped
        if before is not None:
            shaped, discount, weight = earned.copy(), self.config.discount, self.config.shaping
            add_shaping(shaped.reshape(-1), before, self._potential(), discount, weight)
            rewards = self._earned.credit(shaped)
        infos = self._infos(self._of_learners(unshaped))
        never = np.zeros(self.n_worlds, np.bool_)
        return self._observe(), self._of_learners(rewards), never, self.is_over, infos

    def state(self) -> Float32[Array, "worlds numbers"]:
        """The truth about every world, as `state_layout` says; for centralised critics."""
        found: Float32[Array, "worlds numbers"] = self.truth.state(self.episodes.share_gone)
        if self._state is not None:
            self._state(found)
        return found

    def log(self) -> Float64[Array, "worlds learners infos"]:
        """What is logged of each learner, in the order of `infos`; worked out when asked for."""
        found: Array = self.truth.log()
        of_robots = found.reshape(self.n_worlds, self.world.n_robots, -1)
        return np.asarray(self._of_learners(of_robots))

    def snapshot(self) -> Any:  # noqa: ANN401 for `restore` alone
        """All that the next steps depend on: to be restored any number of times, and pickled."""
        kept = self.episodes.snapshot(), self._last_action.copy(), self._frames.snapshot()
        return self.loop.snapshot(), kept

    def restore(self, snapshot: Any) -> None:  # noqa: ANN401 of `snapshot`
        """Go on as when the snapshot was taken, bit for bit.

        ConfigError if it is of a block of another kind or of other sizes.
        """
        loop, rest = parts_of(snapshot, 2)
        episodes, last_action, frames = parts_of(rest, 3)
        if last_action.shape != self._last_action.shape or not self._frames.fits(frames):
            raise ConfigError("restore(): the snapshot is of an environment of other options")
        self.loop.restore(loop)
        self.episodes.restore(episodes)
        self._last_action[...] = last_action
        self._frames.restore(frames)

    def _repr_html_(self) -> str:
        """A picture of the first world and a table, for notebooks."""
        return html_of(self, type(self).__name__, title_of(self._made_by[2], self))

    def __getstate__(self) -> dict[str, Any]:
        """What makes the same environment again, and how it stands."""
        return {"made_by": self._made_by, "snapshot": self.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the environment again, and let it go on where it was."""
        scenario, n_worlds, controller, stagger, options = state["made_by"]
        ArrayEnv.__init__(self, scenario, n_worlds, controller, stagger, **options)
        self.restore(state["snapshot"])

    def _made_loop(self, parts: Parts) -> Loop:
        """The worlds, and who runs the robots."""
        config, seeds = parts.config, range(self.n_worlds)
        return Loop(parts.scenario, parts.controller, seeds, config.physics, config.threads)

    def _hand_over(self) -> None:
        """Mark the layers of the learners as theirs."""
        action = self.world.robots["action"]
        for layer in self.policy.replaces:
            is_residual = self.config.residual and layer == "motion"
            action[layer][:, self._learns] = CORRECT if is_residual else REPLACE

    def _made_stepper(self) -> Stepper:
        """What a step is."""
        if self.config.step_on == "exchange":
            return Exchanges(self.loop, self.episodes, self._learns)
        return Ticks(self.loop, self.episodes, self.config.period)

    def _describe(self) -> None:
        """Make the spaces, and what writes observations and the state."""
        scenarios = self.episodes.extremes
        form = PolicyForm(scenarios, self.config)
        self.observer, self._act = form.observe, form.act
        self._frames = form.frames(self.n_worlds)
        self.observation_layout, self.observation_space = form.layout, form.observation_space
        self.action_layout, self.action_space = form.action.layout, form.action_space
        self.action_shape = form.action.shape
        self.actions = Actions(_names(self.learners, self.n_worlds), form.action)
        truths = [
            self.task.global_state(self.world, self.loop.controller, self.agents, each)
            for each in scenarios
        ]
        self.truth = max(truths, key=lambda each: len(each.layout))
        state_layout = Layout(widest([each.layout for each in truths]))
        is_normal = self.config.normalise
        self._state = Normaliser(state_layout) if is_normal else None
        self.state_layout = normalised(state_layout) if is_normal else state_layout
        self.state_space: Box = self.state_layout.box()

    def _observe(
        self, fresh: Int64[Array, " worlds"] | None = None
    ) -> Float32[Array, "worlds learners numbers"]:
        """What every learner observes; worlds that are `fresh` have no earlier frames."""
        episodes, last = self.episodes, self._last_action
        seen = self.observer(self.world, self.loop.controller, episodes.share_left, last)
        seen = self._frames.add(seen) if fresh is None else self._frames.begin(seen, fresh)
        return self._of_learners(seen)

    def _infos(self, unshaped: Float64[Array, "worlds learners"]) -> Infos:
        acts = self._stepper.acts()
        told = {} if acts is None else {"acts": self._of_learners(acts).astype(np.float64)}
        drawn = {name: numbers.copy() for name, numbers in self.episodes.drawn.items()}
        return {"unshaped_reward": unshaped, **told, **drawn}

    def _of_learners(self, of_robots: Array) -> Array:
        """The columns of those that learn."""
        return of_robots[:, self._learns]


class _Worlds(Part):
    """Validation of the number of worlds."""

    n_worlds: Count


def _names(learners: Sequence[str], n_worlds: int) -> list[str]:
    """The names of all learners, in the order of the rows."""
    if n_worlds == 1:
        return list(learners)
    return [f"{name} of world {w}" for w in range(n_worlds) for name in learners]
