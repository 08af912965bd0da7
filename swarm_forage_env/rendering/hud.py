"""Head-up display: names, clock and counts above the arena; legend and selected robot below."""

from collections.abc import Callable, Mapping
from functools import lru_cache, partial

import numpy as np
import pygame

from swarm_forage_env.rendering import palette, shapes
from swarm_forage_env.rendering.layout import P_RING, Layout
from swarm_forage_env.rendering.palette import Colour
from swarm_forage_env.rendering.shapes import Point
from swarm_forage_env.scene import WITHIN, Scene, Stage

FINENESS = 4
"""Factor by which text and icons are enlarged when drawn; scaling down smooths their edges."""

MAX_CACHED_TEXTS = 512
"""Number of rendered texts in the cache."""

BELIEF = f"dashed: where it believes the area is; ring: {100 * P_RING:g} cm wider per metre of p"
"""Key to the drawing of beliefs."""

ESTIMATE = "ellipse: 95 % of where it believes it is, with a line to where it is"
"""Key to the drawing of beliefs in the waypoints task."""

HELP = "space pause   . step   + - speed   tab or click select   t b m toggle   s save   q quit"
"""Keys of the live window."""

Icon = Callable[[pygame.Surface, Point, float, float], object]
"""Function that draws an icon of the legend at a centre; radius and line width in pixels."""


class HeadUpDisplay:
    """The text and the legend of a picture, outside the arena."""

    def __init__(self, stage: Stage, layout: Layout, picture: pygame.Surface) -> None:
        self._stage, self._layout, self._picture = stage, layout, picture
        pygame.font.init()
        self._font = pygame.font.Font(None, layout.text * FINENESS)
        """Font bundled with pygame-ce, the same on all systems."""
        self._words = lru_cache(MAX_CACHED_TEXTS)(self._drawn_words)
        self._blank = pygame.Surface(picture.get_size(), depth=32)
        """Background: the parts that are the same in every picture."""
        self._blank.fill(palette.PAGE)
        for line, icons in enumerate(legend_of(stage)):
            self._draw_icons(icons, line)
        if layout.beliefs and stage.believes:
            self._draw_key_of_beliefs()
        if layout.keys:
            line = layout.legend_lines + 1 + stage.believes
            self._write_line(self._blank, HELP, line, palette.FAINT)

    def draw(self, scene: Scene, selected: int | None, note: str) -> None:
        """Draw everything but the arena."""
        layout = self._layout
        self._picture.blit(self._blank, (0, 0))
        self._draw_title(scene, note)
        left, y = layout.margin, layout.margin // 2 + layout.line
        for name, value in self._counts(scene):
            left += self._write(self._picture, name, left, y, palette.FAINT) + layout.margin // 2
            left += self._write(self._picture, value, left, y) + 2 * layout.margin
        self._draw_progress(scene.time)
        if layout.beliefs:
            words = "No robot selected" if selected is None else self._words_on(scene, selected)
            self._write_line(self._picture, words, layout.legend_lines)

    def _counts(self, scene: Scene) -> list[tuple[str, str]]:
        score, share = self._stage.headings
        counts = [(score, f"{scene.total}"), (share, f"{100.0 * scene.share:.0f} %")]
        if scene.localised is not None:
            counts.insert(1, ("Wrong claims", f"{int(scene.localised.wrong.sum())}"))
        return [*counts, ("Robots", f"{self._stage.n_robots}")]

    def _draw_title(self, scene: Scene, note: str) -> None:
        layout, y = self._layout, self._layout.margin // 2
        clock = f"{clock_text(scene.time)} of {clock_text(self._stage.duration)}"
        clock = f"{note}   {clock}" if note else clock
        width = self._width_of(clock)
        self._write(self._picture, clock, layout.width - layout.margin - width, y)
        width_left = layout.width - 4 * layout.margin - width
        title = self._cut(f"{self._stage.scenario}   {self._stage.controller}", width_left)
        self._write(self._picture, title, layout.margin, y)

    def _draw_progress(self, time: float) -> None:
        """Draw the progress bar of the episode above the arena."""
        layout = self._layout
        left, y = layout.margin, layout.margin // 2 + 2 * layout.line
        length, height = layout.width - 2 * layout.margin, max(2, round(2 * layout.unit))
        share = min(1.0, time / self._stage.duration)
        self._picture.fill(palette.RULE, (left, y, length, height))
        self._picture.fill(palette.INK, (left, y, round(share * length), height))

    def _draw_icons(self, icons: Mapping[str, Icon], line: int) -> None:
        left, y, gap = float(self._layout.margin), self._below(line), 4.0 * self._layout.unit
        for name, draw in icons.items():
            width = (1.35 if name == MESSAGE else 0.9) * self._layout.text
            left += self._shrink(draw, width, left, y) + gap
            left += self._write(self._blank, name, left, y) + 2.5 * gap

    def _draw_key_of_beliefs(self) -> None:
        layout, left = self._layout, float(self._layout.margin)
        line = layout.legend_lines + 1
        if self._stage.goals is None:
            icon_width = self._shrink(_draw_belief, layout.line, left, self._below(line))
            left += icon_width + 4.0 * layout.unit
        text = BELIEF if self._stage.goals is None else ESTIMATE
        self._write_line(self._blank, text, line, palette.FAINT, left)

    def _shrink(self, draw: Icon, width: float, x: float, y: float) -> int:
        """Draw an enlarged icon and blit it at text size; returns its width [px]."""
        layout = self._layout
        large = pygame.Surface((round(width * FINENESS), layout.line * FINENESS), depth=32)
        large.fill(palette.PAGE)
        centre = 0.5 * large.get_width(), 0.5 * large.get_height()
        draw(large, centre, 0.45 * layout.text * FINENESS, layout.unit * FINENESS)
        size = large.get_width() // FINENESS, large.get_height() // FINENESS
        self._blank.blit(pygame.transform.smoothscale(large, size), (round(x), y))
        return size[0]

    def _words_on(self, scene: Scene, robot: int) -> str:
        is_faulty = scene.faulty is not None and scene.faulty[robot]
        activity = self._stage.states[scene.activity[robot]]
        words = [f"Robot {robot}: {activity}{', faulty' if is_faulty else ''}"]
        if (own := scene.localised) is not None:
            places = np.stack([own.believed[robot], own.goal[robot]]) - scene.pose[robot, :2]
            off, away = np.hypot(*places.T)
            long = 100.0 * WITHIN * own.ellipse[robot, 0]
            words += [f"{100.0 * off:.0f} cm off, ellipse {long:.0f} cm", f"goal {away:.1f} m away"]
            words.append(f"{own.right[robot]} claimed rightly, {own.wrong[robot]} wrongly")
            return "   ".join(words)
        for area, name in enumerate(("nest", "prey") if self._stage.believes else ()):
            if scene.known[robot, area]:
                believed = scene.believed[robot, area]
                true = self._stage.nearest_area(area, believed, scene.time)
                off = np.hypot(*(believed - true))
                words.append(f"{name} {100 * off:.0f} cm off, p {scene.p[robot, area]:.2f} m")
            else:
                words.append(f"{name} unknown")
        return "   ".join(words)

    def _below(self, line: int) -> int:
        """Return the top of a line of text below the arena [px]."""
        layout = self._layout
        return layout.corner[1] + layout.arena[1] + layout.margin // 2 + line * layout.line

    def _write_line(
        self, on: pygame.Surface, text: str, line: int, ink: Colour = palette.INK, left: float = 0.0
    ) -> None:
        """Write a text, cut to the available width, in a line below the arena."""
        left = left or self._layout.margin
        width_left = self._layout.width - self._layout.margin - left
        self._write(on, self._cut(text, width_left), left, self._below(line), ink)

    def _write(
        self, on: pygame.Surface, text: str, x: float, y: float, ink: Colour = palette.INK
    ) -> int:
        words = self._words(text, ink)
        on.blit(words, (round(x), round(y) + (self._layout.line - words.get_height()) // 2))
        return words.get_width()

    def _drawn_words(self, text: str, ink: Colour) -> pygame.Surface:
        large = self._font.render(text, True, ink)
        size = self._width_of(text), round(large.get_height() / FINENESS)
        return pygame.transform.smoothscale(large, size)

    def _width_of(self, text: str) -> int:
        return round(self._font.size(text)[0] / FINENESS)

    def _cut(self, text: str, width_left: float) -> str:
        """Cut a text to a width [px]."""
        if self._width_of(text) <= width_left:
            return text
        while text and self._width_of(text + "...") > width_left:
            text = text[:-1]
        return text + "..."


MESSAGE = "message"

GOALS: dict[str, Icon] = {
    "goal": shapes.draw_goal,
    "claimed rightly": lambda on, at, r, _: shapes.draw_right(on, at, r),
    "claimed wrongly": lambda on, at, r, _: shapes.draw_wrong(on, at, r),
    "believed": lambda on, at, r, px: shapes.draw_ellipse(
        on, at, (r, 0.6 * r), 0.5, round(1.2 * px)
    ),
    "lidar": lambda on, at, r, px: pygame.draw.circle(on, palette.LIDAR, at, r, round(1.2 * px)),
}
"""Second line of the legend in the waypoints task."""


def legend_of(stage: Stage) -> list[dict[str, Icon]]:
    """Return the lines of the legend: name -> icon."""
    names = enumerate(stage.states)
    robots: dict[str, Icon] = {name: partial(_draw_robot, code) for code, name in names if name}
    if stage.goals is not None:
        return [robots, GOALS]
    robots[MESSAGE] = _draw_message
    if stage.has_faults:
        robots["faulty"] = lambda on, at, r, px: shapes.draw_fault_mark(on, at, r, round(1.2 * px))
    return [robots]


def _draw_robot(code: int, on: pygame.Surface, at: Point, radius: float, pixel: float) -> None:
    shapes.draw_robot(on, at, 0.0, code, (radius, pixel))


def _draw_message(on: pygame.Surface, at: Point, radius: float, pixel: float) -> None:
    sender, receiver = np.array([[-1.5 * radius, 0.2 * at[1]], [1.5 * radius, 0.2 * at[1]]]) + at
    shapes.draw_arc(on, sender, receiver, round(1.5 * pixel))


def _draw_belief(on: pygame.Surface, at: Point, radius: float, pixel: float) -> None:
    shapes.draw_belief(on, np.array(at), (0.55 * at[1], 0.9 * at[1]), palette.BLUE, 0.6 * pixel)


def clock_text(seconds: float) -> str:
    """Format seconds as minutes:seconds.

    >>> clock_text(754.2)
    '12:34'
    """
    minutes, rest = divmod(int(seconds + 1e-6), 60)
    return f"{minutes}:{rest:02d}"
