"""Viewer: what the render() of every environment draws with."""

from importlib.util import find_spec
from typing import TYPE_CHECKING

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.frame import Frame, frame_of
from swarm_forage_env.rendering.text_map import text_of
from swarm_forage_env.scene import Scene, Stage

if TYPE_CHECKING:
    from swarm_forage_env.rendering.window import Window

RENDER_MODES = ("human", "rgb_array", "ansi")
"""A live window, frames as arrays, or maps of characters."""

FRAME_WIDTH, WINDOW_WIDTH = 512, 720
"""Default width of a picture [px]."""


def installed_modes() -> list[str]:
    """The render modes that can be had here: without pygame maps of characters alone."""
    return [mode for mode in RENDER_MODES if mode == "ansi" or find_spec("pygame") is not None]


def check_render_mode(render_mode: object) -> None:
    """ConfigError for anything but None and a render mode, or where pygame-ce is missing."""
    if render_mode is None:
        return
    if render_mode not in RENDER_MODES:
        known = ", ".join(f"'{mode}'" for mode in RENDER_MODES)
        raise ConfigError(f"render_mode={render_mode!r}: must be one of {known}, or left out")
    if render_mode not in installed_modes():
        raise ConfigError(
            f"render_mode={render_mode!r} needs 'pygame': pip install 'swarm-forage[render]'"
        )


class Viewer:
    """Shows the scenes of one stage: in a window ("human"), as frames ("rgb_array") or as text.

    `width` is that of a picture [px]; the beliefs of robot `select` are drawn. Nothing is opened
    before the first scene is drawn.
    """

    def __init__(
        self, stage: Stage, mode: str, width: int | None = None, select: int | None = None
    ) -> None:
        self.window: "Window | None" = None  # noqa: UP037 imported below
        self._stage, self._is_text = stage, mode == "ansi"
        if self._is_text:
            return
        from swarm_forage_env.rendering.layout import Layout, checked_size
        from swarm_forage_env.rendering.painter import Painter, Show
        from swarm_forage_env.rendering.window import Window

        if mode == "human":
            self.window = Window(stage, width or WINDOW_WIDTH, select=select)
            return
        layout = Layout(stage, checked_size(width or FRAME_WIDTH), beliefs=select is not None)
        self._painter = Painter(stage, layout)
        self._show = Show(selected=select)

    def draw(self, scene: Scene) -> UInt8[Array, "height width 3"] | str | None:
        """The frame of a scene, or its map; None where it went to the window, or that is closed."""
        if self._is_text:
            return text_of(self._stage, scene)
        if self.window is not None:
            self.window.show(scene)
            return None
        self._painter.take(scene)
        return frame_of(self._painter.paint(scene, self._show)).view(Frame)

    def close(self) -> None:
        """Close the window, if there is one; again does nothing."""
        if self.window is not None:
            self.window.close()
