"""Frames: pictures as arrays, which a notebook shows as pictures."""

import base64
from io import BytesIO

import numpy as np


class Frame(np.ndarray):
    """An array of rows of red, green and blue, from the top; a notebook shows it as a picture."""

    def _repr_html_(self) -> str | None:
        """The picture, for notebooks; None of what is no picture any more, as a part of one."""
        if self.ndim != 3 or self.shape[2] != 3 or self.dtype != np.uint8 or 0 in self.shape:
            return None
        import pygame

        height, width = self.shape[:2]
        picture = pygame.image.frombytes(self.tobytes(), (width, height), "RGB")
        content = BytesIO()
        pygame.image.save(picture, content, ".png")
        text = base64.b64encode(content.getvalue()).decode("ascii")
        return f'<img alt="frame" width="{width}" src="data:image/png;base64,{text}">'
