"""The environment as PettingZoo wants it: `parallel_env`, `raw_env`, `env`."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box
from gymnasium.utils import EzPickle
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils import ClipOutOfBoundsWrapper, OrderEnforcingWrapper, parallel_to_aec

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.actions import Actions
from swarm_forage_env.envs.make import make_array_env
from swarm_forage_env.envs.render import EnvRenderer, Frame, render_modes, title_of
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.interface import Controller
from swarm_forage_env.random_streams import checked_seed, drawn_seed
from swarm_forage_env.rendering.viewer import RENDER_MODES, check_render_mode

Observations = dict[str, Float32[Array, " numbers"]]
Infos = dict[str, dict[str, float]]


METADATA: dict[str, Any] = {
    "name": "swarm_forage_v0",
    "render_modes": list(RENDER_MODES),
    "is_parallelizable": True,
    "render_fps": 10,
}
"""Of the class; an environment says which render modes its scenario has."""


class parallel_env(ParallelEnv, EzPickle):  # type: ignore[misc]  # noqa: N801 PettingZoo's name
    """Foraging e-pucks, or robots that visit waypoints, of which a policy is one layer, or all.

    `learn` cuts the control loop: "weighting", "motion", "both" or "everything". The rest is
    done by `controller`, a name with parameters if wanted (`ssgiff:beta=0.01`) or a controller; by
    default `ssgikf`, and `boids-adaptive` for waypoints.
    `scenario` is a name, a TOML file or a Scenario; further keywords change single numbers of
    it, by dotted name: `parallel_env("es1", **{"radio.max_range": 0.2})`.

    With `residual` the policy corrects the hand-written motion instead of replacing it: its
    wheels, times two, are added to that motion's, at each tick of a decision period; a robot
    that is talking is left alone. Zeros are the hand-written motion.

    `reward` is "own" or "team"; `shaping` weighs a potential with the learner's `discount`. An
    action is held for `decision_period` ticks and the rewards of these ticks are added up.
    Nobody dies; after `max_cycles` steps (by default the scenario's time) all are truncated
    together. `observation_layout`, `action_layout` and `state_layout` say what each number is:
    print them. Bounds hold for the longer of the scenario's time and `max_cycles` as given.
    """

    metadata: dict[str, Any] = METADATA

    def __init__(  # noqa: PLR0913 PettingZoo's habit: all options are keywords
        self,
        scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
        learn: str = "motion",
        controller: str | Controller | None = None,
        residual: bool = False,
        reward: str = "own",
        shaping: float = 0.0,
        discount: float = 0.99,
        decision_period: int = 1,
        physics: str | None = None,
        render_mode: str | None = None,
        max_cycles: int | None = None,
        threads: int = 1,
        **overrides: Any,  # noqa: ANN401 numbers of the scenario, checked there
    ) -> None:
        """Make the environment; `reset` starts an episode."""
        options = {
            "learn": learn, "residual": residual, "reward": reward, "shaping": shaping,
            "discount": discount, "decision_period": decision_period, "physics": physics,
            "max_cycles": max_cycles, "threads": threads,
        }  # fmt: skip
        rest = {"controller": controller, "render_mode": render_mode}
        EzPickle.__init__(self, scenario, **options, **rest, **overrides)
        check_render_mode(render_mode)
        self.render_mode = render_mode
        self._env = env = make_array_env((0,), {**options, **overrides}, scenario, controller)
        self._screen = EnvRenderer(env, render_mode, title_of(controller, learn))
        self.world = env.world
        self.scenario = env.world.scenario
        self.metadata = {**self.metadata, "render_modes": render_modes(self.scenario)}
        self.max_cycles = env.n_cycles
        self.possible_agents = env.agents
        self.agents: list[str] = []
        self.observation_layout = env.observation_layout
        self.action_layout = env.action_layout
        self.state_layout = env.truth.layout
        self.state_space = env.truth.space
        self.observation_spaces = dict.fromkeys(env.agents, env.observation_layout.box())
        self.action_spaces = dict.fromkeys(env.agents, env.action_layout.box())
        self._actions = Actions(env.agents, env.action_layout)
        self._rng: np.random.Generator | None = None
        self._cycles: int | None = None

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observations, Infos]:
        """Start an episode; a seed fixes it and all that follow without one."""
        observations = self._env.reset([self._draw_seed(seed)])
        self.agents = self.possible_agents[:]
        self._cycles = 0
        self._screen.follow()
        return dict(zip(self.agents, observations, strict=True)), self._infos()

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """One decision period; a refused action leaves everything as it was."""
        cycles = self._started()
        if not self.agents:
            raise ResetNeeded(f"step after the end, at {cycles} cycles: call reset() first")
        observations, rewards = self._env.step(self._actions.matrix(actions))
        self._cycles = cycles + 1
        agents, over = self.agents, self._cycles >= self.max_cycles
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
        """The truth and all beliefs, as `state_layout` says; for centralised critics."""
        share_gone = self._started() / self.max_cycles
        return self._env.state(share_gone)

    def observation_space(self, agent: str) -> Box:
        """The space of an agent's observations, the same object each time."""
        return self._space_of(agent, self.observation_spaces)

    def action_space(self, agent: str) -> Box:
        """The space of an agent's actions, the same object each time."""
        return self._space_of(agent, self.action_spaces)

    def render(self) -> Frame | None:
        """The frame of this moment as rows of red, green and blue; None where it is on the screen.

        ConfigError where no `render_mode` was given, or no display is found for a window.
        """
        self._started()
        return self._screen.draw()[0]

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _space_of(self, agent: str, spaces: Mapping[str, Box]) -> Box:
        if agent not in spaces:
            raise UnknownNameError("agent", str(agent), spaces)
        return spaces[agent]

    def _infos(self) -> Infos:
        names = self._env.infos
        log = (dict(zip(names, row, strict=True)) for row in self._env.log())
        return dict(zip(self.possible_agents, log, strict=True))

    def _started(self) -> int:
        if self._cycles is None:
            raise ResetNeeded("the episode has not begun: call reset() first")
        return self._cycles

    def _draw_seed(self, seed: int | None) -> int:
        """The world's seed: the given one, else the next of the sequence that it began."""
        if seed is not None:
            seed = checked_seed(seed)
            self._rng = np.random.default_rng(seed)
            return seed
        if self._rng is None:
            self._rng = np.random.default_rng()
        return drawn_seed(self._rng)


def raw_env(scenario: Any = "es1", **options: Any) -> AECEnv:  # noqa: ANN401 as parallel_env
    """The environment with agents acting in turn, as bare as `parallel_env`."""
    return parallel_to_aec(parallel_env(scenario, **options))


def env(scenario: Any = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """The environment with agents acting in turn: actions clipped, order of calls checked."""
    return OrderEnforcingWrapper(ClipOutOfBoundsWrapper(raw_env(scenario, **options)))
