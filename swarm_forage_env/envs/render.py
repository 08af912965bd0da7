"""Rendering of environments: in a window, as frames, as text, or in a notebook."""

from typing import TYPE_CHECKING

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.notebook import html_of, title_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.rendering.viewer import Viewer, installed_modes
from swarm_forage_env.task import World, stage_of

if TYPE_CHECKING:
    from swarm_forage_env.rendering.window import Window

Frame = UInt8[Array, "height width 3"]


class EnvRenderer:
    """Renderer of each world of a batch, under one of the render modes or none.

    A window opens when the first scene is drawn. Raises ConfigError for a window on several
    worlds, and for worlds that cannot be drawn.
    """

    def __init__(self, env: ArrayEnv, mode: str | None) -> None:
        self._env, self._mode = env, mode
        self._views: list[Viewer] = []
        if mode is None:
            return
        n_worlds = env.world.n_worlds
        if mode == "human" and n_worlds > 1:
            raise ConfigError(
                f"render_mode='human': one window shows one world, not {n_worlds}; use"
                " render_mode='rgb_array', or num_envs=1"
            )
        stage = stage_of(env.world.scenario, title_of(env))
        self._views = [Viewer(stage, mode) for _ in range(n_worlds)]

    def __getstate__(self) -> tuple[ArrayEnv, str | None]:
        return self._env, self._mode

    def __setstate__(self, state: tuple[ArrayEnv, str | None]) -> None:
        EnvRenderer.__init__(self, *state)

    def draw(self) -> list[Frame | str | None]:
        """Return the current frame or text map of each world, or None if a window shows it."""
        if self._mode is None:
            raise ConfigError(
                "render(): set render_mode='human', 'rgb_array' or 'ansi' when the environment"
                " is made"
            )
        return [view.draw(self._env.loop.scene(w)) for w, view in enumerate(self._views)]

    @property
    def window(self) -> "Window | None":
        """Window, or None if there is none."""
        return self._views[0].window if self._views else None

    def follow(self) -> None:
        """Draw the current state if the mode is `human`, as Gymnasium requires after each step."""
        if self._mode == "human":
            self.draw()

    def close(self) -> None:
        """Close the window, if there is one; further calls do nothing."""
        for view in self._views:
            view.close()


class ShownEnv:
    """Base of the environments for other libraries: an `ArrayEnv` with rendering."""

    array_env: ArrayEnv
    metadata: dict[str, object]

    def _show(self, env: ArrayEnv, render_mode: str | None) -> None:
        self.array_env, self.render_mode = env, render_mode
        self._screen = EnvRenderer(env, render_mode)
        modes = [] if env.task.scene is None else installed_modes()
        self.metadata = {**self.metadata, "render_modes": modes}
        self.max_cycles = env.max_cycles
        self.observation_layout, self.action_layout = env.observation_layout, env.action_layout

    def __repr__(self) -> str:
        return self.array_env.described(type(self).__name__)

    @property
    def world(self) -> World:
        """Worlds of the robots; their records hold the ground truth."""
        return self.array_env.world

    @property
    def scenario(self) -> BaseScenario:
        """Scenario of the first world's episode."""
        return self.world.scenario

    def snapshot(self) -> object:
        """Return the full state, which can be pickled and restored any number of times."""
        return self.array_env.snapshot()

    def restore(self, snapshot: object) -> None:
        """Continue from a snapshot, bit for bit; ConfigError if it does not fit."""
        self.array_env.restore(snapshot)

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _repr_html_(self) -> str:
        return html_of(self.array_env, type(self).__name__)
