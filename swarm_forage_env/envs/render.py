"""Pictures of environments: not at all, in a window, as frames, or in a notebook."""

from typing import TYPE_CHECKING

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.notebook import html_of, title_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.rendering.viewer import Viewer, installed_modes
from swarm_forage_env.task import World, stage_of, task_of

if TYPE_CHECKING:
    from swarm_forage_env.rendering.window import Window

Frame = UInt8[Array, "height width 3"]


def render_modes(scenario: BaseScenario) -> list[str]:
    """The render modes of a scenario: those installed, and none of a task that has no drawing."""
    return installed_modes() if task_of(scenario).scene is not None else []


class EnvRenderer:
    """A view of each world of a batch, under one of the render modes or none.

    Nothing is opened before the first scene is drawn, and without a mode nothing is made.
    ConfigError for a window on several worlds, and for a world that cannot be drawn.
    """

    def __init__(self, env: ArrayEnv, mode: str | None) -> None:
        self._env, self._mode = env, mode
        self._views: list[Viewer] = []
        if mode is None:
            return
        n_worlds = env.world.n_worlds
        if mode == "human" and n_worlds > 1:
            raise ConfigError(
                f"render_mode='human': one window shows one world, not {n_worlds}; take"
                " render_mode='rgb_array', or num_envs=1"
            )
        stage = stage_of(env.world.scenario, title_of(env))
        self._views = [Viewer(stage, mode) for _ in range(n_worlds)]

    def __getstate__(self) -> tuple[ArrayEnv, str | None]:
        return self._env, self._mode

    def __setstate__(self, state: tuple[ArrayEnv, str | None]) -> None:
        EnvRenderer.__init__(self, *state)

    def draw(self) -> list[Frame | str | None]:
        """The frame, or the map, of each world as it stands; None where it is on the screen.

        ConfigError where no render mode was given, or no display is found for a window.
        """
        if self._mode is None:
            raise ConfigError(
                "render(): give render_mode='human', 'rgb_array' or 'ansi' where the environment is"
                " made"
            )
        return [view.draw(self._env.loop.scene(which)) for which, view in enumerate(self._views)]

    @property
    def window(self) -> "Window | None":
        """The window; None where there is none."""
        return self._views[0].window if self._views else None

    def follow(self) -> None:
        """A window shows each step by itself, as everywhere in Gymnasium."""
        if self._mode == "human":
            self.draw()

    def close(self) -> None:
        """Close the window, if there is one; again does nothing."""
        for view in self._views:
            view.close()


class ShownEnv:
    """What the APIs of other libraries have in common: an `ArrayEnv` and its pictures."""

    array_env: ArrayEnv
    metadata: dict[str, object]

    def _show(self, env: ArrayEnv, render_mode: str | None) -> None:
        self.array_env, self.render_mode = env, render_mode
        self._screen = EnvRenderer(env, render_mode)
        self.metadata = {**self.metadata, "render_modes": render_modes(self.scenario)}
        self.max_cycles = env.max_cycles
        self.observation_layout, self.action_layout = env.observation_layout, env.action_layout

    def __repr__(self) -> str:
        return self.array_env.described(type(self).__name__)

    @property
    def world(self) -> World:
        """The worlds of the robots: their records are the truth."""
        return self.array_env.world

    @property
    def scenario(self) -> BaseScenario:
        """The scenario of the first world's episode."""
        return self.world.scenario

    def snapshot(self) -> object:
        """All that the next steps depend on: to be restored any number of times, and pickled."""
        return self.array_env.snapshot()

    def restore(self, snapshot: object) -> None:
        """Go on as when the snapshot was taken, bit for bit; ConfigError if it does not fit."""
        self.array_env.restore(snapshot)

    def close(self) -> None:
        """Close the window, if there is one."""
        self._screen.close()

    def _repr_html_(self) -> str:
        return html_of(self.array_env, type(self).__name__)
