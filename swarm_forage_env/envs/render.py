"""Rendering of environments: not at all, in a window, or as frames."""

from typing import Any

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.notebook import html_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.viewer import RENDER_MODES, Viewer
from swarm_forage_env.task import stage_of, task_of

Frame = UInt8[Array, "height width 3"]


def render_modes(scenario: Any) -> list[str]:  # noqa: ANN401 of any task
    """The render modes of a scenario: none of a task that has no drawing."""
    return list(RENDER_MODES) if task_of(scenario).scene is not None else []


class EnvRenderer:
    """A view of each world of a batch, under one of the render modes or none.

    Without a mode nothing is made, and nothing costs time. ConfigError for a window on several
    worlds, and for a world that cannot be drawn.
    """

    def __init__(self, env: ArrayEnv, mode: str | None, moved_by: str) -> None:
        """Nothing is opened before the first scene is drawn."""
        self._env, self._mode, self._moved_by = env, mode, moved_by
        self._views: list[Viewer] = []
        if mode is None:
            return
        n_worlds = env.world.n_worlds
        if mode == "human" and n_worlds > 1:
            raise ConfigError(
                f"render_mode='human': one window shows one world, not {n_worlds}; take"
                " render_mode='rgb_array', or num_envs=1"
            )
        stage = stage_of(env.world.scenario, moved_by)
        self._views = [Viewer(stage, mode) for _ in range(n_worlds)]

    def __getstate__(self) -> tuple[ArrayEnv, str | None, str]:
        """What makes the same renderer again; a window stays where it is."""
        return self._env, self._mode, self._moved_by

    def __setstate__(self, state: tuple[ArrayEnv, str | None, str]) -> None:
        """A renderer of the copy, which has opened nothing."""
        EnvRenderer.__init__(self, *state)

    def draw(self) -> list[Frame | None]:
        """The frame of each world as it stands; None where it is on the screen.

        ConfigError where no render mode was given, or no display is found for a window.
        """
        if self._mode is None:
            raise ConfigError(
                "render(): give render_mode='human' or 'rgb_array' where the environment is made"
            )
        return [view.draw(self._env.loop.scene(which)) for which, view in enumerate(self._views)]

    @property
    def window(self) -> Any:  # noqa: ANN401 a Window, which only pygame can make
        """The window; None where there is none."""
        return self._views[0].window if self._views else None

    def html(self, kind: str) -> str:
        """What a notebook shows of an environment whose class is called so."""
        return html_of(self._env, kind, self._moved_by)

    def follow(self) -> None:
        """A window shows each step by itself, as everywhere in Gymnasium."""
        if self._mode == "human":
            self.draw()

    def close(self) -> None:
        """Close the window, if there is one; again does nothing."""
        for view in self._views:
            view.close()
