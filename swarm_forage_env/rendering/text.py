"""Text of pictures: lines drawn large and made smaller, so that letters keep their distances."""

import pygame

from swarm_forage_env.rendering.palette import Colour

FINENESS = 4
"""Letters are drawn this many times larger."""

ROOM = 512
"""Lines kept for the next picture."""


class TextRenderer:
    """Text of one height. The font comes with pygame-ce: the same everywhere."""

    def __init__(self, height: int) -> None:
        """Letters about so high [px]."""
        pygame.font.init()
        self._font = pygame.font.Font(None, height * FINENESS)
        self._lines: dict[tuple[str, Colour], pygame.Surface] = {}

    def width(self, text: str) -> int:
        """How wide a line is [px]."""
        return round(self._font.size(text)[0] / FINENESS)

    def line(self, text: str, ink: Colour) -> pygame.Surface:
        """One line of text on nothing."""
        key = text, ink
        if key not in self._lines:
            if len(self._lines) >= ROOM:
                self._lines.clear()
            large = self._font.render(text, True, ink)
            size = self.width(text), round(large.get_height() / FINENESS)
            self._lines[key] = pygame.transform.smoothscale(large, size)
        return self._lines[key]

    def cut(self, text: str, room: float) -> str:
        """As much of a text as there is room for [px]."""
        if self.width(text) <= room:
            return text
        while text and self.width(text + "...") > room:
            text = text[:-1]
        return text + "..."
