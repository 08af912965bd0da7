"""Viewer: implements render() of all environments; frames as arrays and maps as text."""

import base64
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from swarm_forage_env.arrays import NEST, Array, Float64, UInt8
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scene import Scene, Stage

if TYPE_CHECKING:
    import pygame

    from swarm_forage_env.rendering.window import Window

RENDER_MODES = ("human", "rgb_array", "ansi")
"""Render modes: a live window, frames as arrays, or maps as text."""

FRAME_WIDTH, WINDOW_WIDTH = 512, 720
"""Default width of a picture [px]."""


class Frame(np.ndarray):
    """Array of shape (height, width, 3), RGB, top row first; a notebook shows it as an image."""

    def _repr_html_(self) -> str | None:
        """Return the image for notebooks; None if the array is no image, such as a slice of one."""
        if self.ndim != 3 or self.shape[2] != 3 or self.dtype != np.uint8 or 0 in self.shape:
            return None
        import pygame

        height, width = self.shape[:2]
        picture = pygame.image.frombytes(self.tobytes(), (width, height), "RGB")
        text = base64.b64encode(png(picture)).decode("ascii")
        return f'<img alt="frame" width="{width}" src="data:image/png;base64,{text}">'


def frame_of(picture: "pygame.Surface") -> UInt8[Array, "height width 3"]:
    """Return a copy of a picture as an array: RGB, top row first."""
    import pygame

    width, height = picture.get_size()
    pixels = np.frombuffer(pygame.image.tobytes(picture, "RGB"), np.uint8)
    return pixels.reshape(height, width, 3).copy()


def save(picture: "pygame.Surface", file: Path) -> None:
    """Write a picture to a PNG file, atomically. OSError if that fails."""
    write_atomically(file, png(picture))


def png(picture: "pygame.Surface") -> bytes:
    """Return a picture as the content of a PNG file."""
    import pygame

    content = BytesIO()
    pygame.image.save(picture, content, ".png")
    return content.getvalue()


def installed_modes() -> list[str]:
    """Return the available render modes; only "ansi" without pygame."""
    return [mode for mode in RENDER_MODES if mode == "ansi" or find_spec("pygame") is not None]


def check_render_mode(render_mode: object) -> None:
    """Raise ConfigError unless the render mode is None, or known and installed."""
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
    """Viewer of one stage: in a window ("human"), as frames ("rgb_array") or as text ("ansi").

    `width` is the width of a picture [px]. The window opens when the first scene is drawn.
    """

    def __init__(self, stage: Stage, mode: str, width: int | None = None) -> None:
        self.window: "Window | None" = None  # noqa: UP037 imported below
        self._stage, self._is_text = stage, mode == "ansi"
        if self._is_text:
            return
        from swarm_forage_env.rendering.layout import Layout
        from swarm_forage_env.rendering.painter import Painter, Show
        from swarm_forage_env.rendering.window import Window

        if mode == "human":
            self.window = Window(stage, width or WINDOW_WIDTH)
            return
        self._painter = Painter(stage, Layout(stage, width or FRAME_WIDTH))
        self._show = Show()

    def draw(self, scene: Scene) -> UInt8[Array, "height width 3"] | str | None:
        """Return the frame or the map of a scene; None in mode "human", which shows it."""
        if self._is_text:
            return text_of(self._stage, scene)
        if self.window is not None:
            self.window.show(scene)
            return None
        self._painter.take(scene)
        return frame_of(self._painter.paint(scene, self._show)).view(Frame)

    def close(self) -> None:
        """Close the window, if there is one; further calls have no effect."""
        if self.window is not None:
            self.window.close()


COLUMNS = 60
"""Characters per row of a map."""

ASPECT = 2.0
"""Height of a character divided by its width."""

FLOOR, NEST_SIGN, PREY_SIGN, ROBOT, GOAL = ".#%o+"


def text_of(stage: Stage, scene: Scene) -> str:
    """Return a map of the arena, x to the right and y upwards, and a line with time and score.

    A robot is its index if there are up to ten, else `o`; the nest is #, prey areas %, goals +.
    """
    rows = max(1, round(COLUMNS * stage.width / stage.length / ASPECT))
    size, half = np.array([COLUMNS, rows]), np.array([stage.length, stage.width]) / 2.0
    x, y = np.meshgrid(*((np.arange(n) + 0.5) / n * 2.0 - 1.0 for n in size))
    places = np.stack([x * half[0], y * half[1]], axis=-1)
    signs = np.full((rows, COLUMNS), FLOOR)
    for kind, centre in zip(stage.kinds, stage.areas_at(scene.time), strict=True):
        is_inside = np.hypot(*np.moveaxis(places - centre, -1, 0)) <= stage.area_radius
        signs[is_inside] = NEST_SIGN if kind == NEST else PREY_SIGN
    if scene.localised is not None:
        signs[_cells(scene.localised.goal, half, size)] = GOAL
    column, row = _cells(scene.pose[:, :2], half, size)[::-1]
    digits = [str(k) if stage.n_robots <= 10 else ROBOT for k in range(stage.n_robots)]
    signs[row, column] = digits
    score, share = stage.headings
    status = f"{scene.time:.1f} s, {score.lower()} {scene.total}, {share.lower()} {scene.share:.0%}"
    return "\n".join(["".join(line) for line in signs[::-1]] + [status])


def _cells(places: Float64[Array, "places 2"], half: Array, size: Array) -> tuple[Array, Array]:
    cells = np.clip(((places / half + 1.0) / 2.0 * size).astype(np.int64), 0, size - 1)
    return cells[:, 1], cells[:, 0]
