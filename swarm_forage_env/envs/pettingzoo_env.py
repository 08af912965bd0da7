"""PettingZoo environments: `parallel_env`, `raw_env` and `env`."""

from collections.abc import Mapping
from copy import deepcopy
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from gymnasium.spaces import Box, Space
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils import (
    AssertOutOfBoundsWrapper,
    ClipOutOfBoundsWrapper,
    OrderEnforcingWrapper,
    parallel_to_aec,
)

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.controllers import Controllers
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.keywords import EnvOptions, Learn, OtherOptions, RenderMode
from swarm_forage_env.envs.make import refuse_keywords_of_blocks
from swarm_forage_env.envs.render import Frame, ShownEnv
from swarm_forage_env.errors import UnknownNameError, shown
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.rendering.viewer import RENDER_MODES, check_render_mode
from swarm_forage_env.scenarios import ScenarioSource

if TYPE_CHECKING:
    from swarm_forage_env.rendering.window import Window

Observations = dict[str, Float32[Array, " numbers"]]
Infos = dict[str, dict[str, float]]


class parallel_env(ShownEnv, ParallelEnv):  # type: ignore[misc]  # noqa: N801 PettingZoo's name
    """The PettingZoo environment: foraging e-pucks, or robots that visit waypoints.

    A policy replaces the layers of `learn`, and `controller` runs the others. All agents act in
    each step, no agent terminates, and after `max_cycles` steps all are truncated together.
    `observation_layout`, `action_layout` and `state_layout` describe each feature: print them.

    Parameters of the scenario are keywords, too, by dotted name:
    `parallel_env("es1", **{"radio.max_range": 0.2})`, or, for type checkers,
    `parallel_env(find_scenario("es1", {"radio.max_range": 0.2}))`.

    With `residual` the policy corrects the hand-written motion instead of replacing it: its wheel
    speeds, times two, are added to that motion's at each tick of a decision period, except while
    the robot talks. An action of zeros leaves that motion unchanged.

    >>> env = parallel_env("es1", learn="motion", max_cycles=5)
    >>> observations, infos = env.reset(seed=0)
    >>> observations["epuck_0"].shape
    (45,)

    Args:
        scenario: A name, a TOML file or a `Scenario`.
        learn: Layers that the policy replaces: `weighting`, `motion`, `both` or `everything`.
        controller: Controller of the other layers: a name, with parameters if wanted, layers as
            `social_odometry+sgiff+subsumption`, or a controller; one for each robot in a list or
            mapping. None: the task's default, `ssgikf`.
        render_mode: `human`, `rgb_array` or `ansi`; None: nothing is drawn.
        **options: The fields of `EnvConfig`, and parameters of the scenario.
    """

    metadata: dict[str, object] = {  # noqa: RUF012 as in PettingZoo
        "name": "swarm_forage_v2",
        "render_modes": list(RENDER_MODES),
        "is_parallelizable": True,
        "render_fps": 10,
    }
    """Metadata; an instance lists the render modes of its scenario."""

    def __init__(
        self,
        scenario: ScenarioSource = "es1",
        learn: Learn = "motion",
        controller: Controllers | None = None,
        render_mode: RenderMode | None = None,
        **options: Unpack[OtherOptions],
    ) -> None:
        check_render_mode(render_mode)
        refuse_keywords_of_blocks(options)
        env = ArrayEnv(scenario, 1, controller, learn=learn, **options)
        self._show(env, render_mode)
        self.possible_agents = env.learners
        self.agents: list[str] = []
        self.state_layout = env.state_layout
        self.state_space = env.state_space
        self.observation_spaces = dict.fromkeys(env.learners, env.observation_space)
        self.action_spaces = {each: deepcopy(env.action_space) for each in env.learners}
        self._infos_of_step: dict[str, Array] = {}

    @property
    def np_random(self) -> np.random.Generator:
        """Copy of the generator of the seeds of episodes that are started without a seed."""
        return self.array_env.episodes.generators[0]

    def reset(
        self, seed: int | None = None, options: Mapping[str, object] | None = None
    ) -> tuple[Observations, Infos]:
        """Start an episode; a seed fixes it and all later ones that are started without a seed."""
        seeds = None if seed is None else [checked_seed(seed)]
        (observations,), self._infos_of_step = self.array_env.reset(seeds, options=options)
        self.agents = self.possible_agents[:]
        self._screen.follow()
        return dict(zip(self.agents, observations, strict=True)), self._infos()

    def step(
        self, actions: Mapping[str, object]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Run one decision period; a refused action leaves the world unchanged."""
        env = self.array_env
        env.episodes.check_running()
        step = env.advance(env.actions.matrix(actions))
        (observations,), (rewards,), _, (is_over,), self._infos_of_step = step
        agents, over = self.agents, bool(is_over)
        if over:
            self.agents = []
        self._screen.follow()
        return (
            dict(zip(agents, observations, strict=True)),
            dict(zip(agents, rewards.tolist(), strict=True)),
            dict.fromkeys(agents, False),
            dict.fromkeys(agents, over),
            self._infos(),
        )

    def state(self) -> Float32[Array, " numbers"]:
        """Return the global state, as in `state_layout`: ground truth and beliefs, for critics."""
        self.array_env.episodes.check_begun()
        return np.asarray(self.array_env.state()[0])

    def restore(self, snapshot: object) -> None:
        """Continue from a snapshot, bit for bit."""
        super().restore(snapshot)
        episodes = self.array_env.episodes
        runs = episodes.has_begun and not episodes.is_over[0]
        self.agents = self.possible_agents[:] if runs else []

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the observation space of an agent, the same object each time."""
        return self._space_of(agent, self.observation_spaces)

    def action_space(self, agent: str) -> Space[Any]:
        """Return the action space of an agent, the same object each time."""
        return self._space_of(agent, self.action_spaces)

    def render(self) -> Frame | str | None:
        """Return the current frame as an RGB array (`ansi`: as text); None if a window shows it.

        Raises ConfigError if no `render_mode` was given or a window finds no display.
        """
        self.array_env.episodes.check_begun()
        return self._screen.draw()[0]

    @property
    def window(self) -> "Window | None":
        """Window if `render_mode="human"`, else None; `ManualPolicy` reads its keys."""
        return self._screen.window

    def _space_of(self, agent: object, spaces: Mapping[str, Space[Any]]) -> Space[Any]:
        if isinstance(agent, str) and agent in spaces:
            return spaces[agent]
        raise UnknownNameError("agent", agent if isinstance(agent, str) else shown(agent), spaces)

    def _infos(self) -> Infos:
        env, step = self.array_env, self._infos_of_step
        names = (*env.infos, *step)
        table = np.empty((len(env.learners), len(names)))
        table[:, : len(env.infos)] = env.log()[0]
        for k, numbers in enumerate(step.values(), len(env.infos)):
            table[:, k] = numbers[0]
        return {
            agent: dict(zip(names, row, strict=True))
            for agent, row in zip(self.possible_agents, table.tolist(), strict=True)
        }


def raw_env(
    scenario: ScenarioSource = "es1",
    *,
    controller: Controllers | None = None,
    render_mode: RenderMode | None = None,
    **options: Unpack[EnvOptions],
) -> AECEnv:
    """Return the AEC environment, in which agents act in turn, without wrappers."""
    bare = parallel_env(scenario, controller=controller, render_mode=render_mode, **options)
    return parallel_to_aec(bare)


def env(
    scenario: ScenarioSource = "es1",
    *,
    controller: Controllers | None = None,
    render_mode: RenderMode | None = None,
    **options: Unpack[EnvOptions],
) -> AECEnv:
    """Return the AEC environment, in which agents act in turn, with actions clipped or checked.

    >>> turns = env("near")
    >>> turns.reset(seed=0)
    >>> for agent in turns.agent_iter(10):
    ...     turns.step(turns.action_space(agent).sample())
    """
    bare = raw_env(scenario, controller=controller, render_mode=render_mode, **options)
    is_box = isinstance(bare.action_space(bare.possible_agents[0]), Box)
    bounded = ClipOutOfBoundsWrapper if is_box else AssertOutOfBoundsWrapper
    return OrderEnforcingWrapper(bounded(bare))
