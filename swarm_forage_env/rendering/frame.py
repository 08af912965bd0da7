"""Frames: pictures as arrays, in files, and in notebooks."""

import base64
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.atomic_write import write_atomically

if TYPE_CHECKING:
    import pygame


class Frame(np.ndarray):
    """An array of rows of red, green and blue, from the top; a notebook shows it as a picture."""

    def _repr_html_(self) -> str | None:
        """The picture, for notebooks; None of what is no picture any more, as a part of one."""
        if self.ndim != 3 or self.shape[2] != 3 or self.dtype != np.uint8 or 0 in self.shape:
            return None
        import pygame

        height, width = self.shape[:2]
        picture = pygame.image.frombytes(self.tobytes(), (width, height), "RGB")
        text = base64.b64encode(png(picture)).decode("ascii")
        return f'<img alt="frame" width="{width}" src="data:image/png;base64,{text}">'


def frame_of(picture: "pygame.Surface") -> UInt8[Array, "height width 3"]:
    """A copy of a picture as an array: rows from the top, red, green and blue."""
    import pygame

    width, height = picture.get_size()
    pixels = np.frombuffer(pygame.image.tobytes(picture, "RGB"), np.uint8)
    return pixels.reshape(height, width, 3).copy()


def save(picture: "pygame.Surface", file: Path) -> None:
    """Write a picture to a PNG file, whole or not at all. OSError where that fails."""
    write_atomically(file, png(picture))


def png(picture: "pygame.Surface") -> bytes:
    """A picture as the content of a PNG file."""
    import pygame

    content = BytesIO()
    pygame.image.save(picture, content, ".png")
    return content.getvalue()
