"""Head-up display: names, clock and counts above the arena; legend and selected robot below."""

import numpy as np
import pygame

from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.goals import draw_ellipse, draw_goal, draw_right, draw_wrong
from swarm_forage_env.rendering.layout import P_RING, Layout
from swarm_forage_env.rendering.palette import Colour
from swarm_forage_env.rendering.shapes import draw_arc, draw_belief, draw_fault_mark, draw_robot
from swarm_forage_env.scene import WITHIN, Localised, Scene, Stage

FINENESS = 4
"""Letters, and the shapes of the legend, are drawn this many times larger, then made smaller."""

ROOM = 512
"""Lines of text kept for the next picture."""

BELIEF = f"dashed: where it believes the area is; ring: {100 * P_RING:g} cm wider per metre of p"
"""What is drawn of beliefs, in words."""

ESTIMATE = "ellipse: 95 % of where it believes it is, with a line to where it is"
"""The same where robots visit goals."""

HELP = "space pause   . step   + - speed   tab or click select   t b m toggle   s save   q quit"
"""The keys of the live window."""


class HeadUpDisplay:
    """The text and the legend of a picture, outside the arena."""

    def __init__(self, stage: Stage, layout: Layout, picture: pygame.Surface) -> None:
        """Letters, and all that stays the same, ready to copy."""
        self._stage = stage
        self._layout = layout
        self._picture = picture
        self._letters = TextRenderer(layout.text)
        self._blank = pygame.Surface(picture.get_size(), depth=32)
        self._blank.fill(palette.PAGE)
        self._legend()
        if layout.beliefs:
            self._legend_of_beliefs()
        if layout.keys:
            text = self._letters.cut(HELP, layout.width - 2 * layout.margin)
            y = self._below(layout.legend_lines + 2)
            self._write(self._blank, text, layout.margin, y, palette.FAINT)

    def draw(self, scene: Scene, selected: int | None, aside: str) -> None:
        """Draw everything but the arena."""
        layout = self._layout
        self._picture.blit(self._blank, (0, 0))
        self._title(scene, aside)
        left, y = layout.margin, layout.margin // 2 + layout.line
        for name, value in self._counts(scene):
            left += self._write(self._picture, name, left, y, palette.FAINT) + layout.margin // 2
            left += self._write(self._picture, value, left, y) + 2 * layout.margin
        self._progress(scene.time)
        if layout.beliefs:
            told = self._letters.cut(self._told(scene, selected), layout.width - 2 * layout.margin)
            self._write(self._picture, told, layout.margin, self._below(layout.legend_lines))

    def _counts(self, scene: Scene) -> list[tuple[str, str]]:
        """The counts above the arena."""
        score, share = self._stage.headings
        counts = [(score, f"{scene.total}"), (share, f"{100.0 * scene.share:.0f} %")]
        if scene.localised is not None:
            counts.insert(1, ("Wrong claims", f"{int(scene.localised.wrong.sum())}"))
        return [*counts, ("Robots", f"{self._stage.n_robots}")]

    def _title(self, scene: Scene, aside: str) -> None:
        """Names to the left, the clock to the right; names are cut before they touch it."""
        layout, y = self._layout, self._layout.margin // 2
        clock = f"{clock_text(scene.time)} of {clock_text(self._stage.duration)}"
        clock = f"{aside}   {clock}" if aside else clock
        width = self._letters.width(clock)
        self._write(self._picture, clock, layout.width - layout.margin - width, y)
        room = layout.width - 4 * layout.margin - width
        title = self._letters.cut(f"{self._stage.scenario}   {self._stage.controller}", room)
        self._write(self._picture, title, layout.margin, y)

    def _progress(self, time: float) -> None:
        """How much of the episode has gone: a line above the arena."""
        layout = self._layout
        left, y = layout.margin, layout.margin // 2 + 2 * layout.line
        length, height = layout.width - 2 * layout.margin, max(2, round(2 * layout.unit))
        share = min(1.0, time / self._stage.duration)
        self._picture.fill(palette.RULE, (left, y, length, height))
        self._picture.fill(palette.INK, (left, y, round(share * length), height))

    def _legend(self) -> None:
        """What the colours mean."""
        layout, y = self._layout, self._below(0)
        r, gap = 0.45 * layout.text, 4.0 * layout.unit
        left: float = layout.margin
        for code, name in enumerate(self._stage.states):
            if not name:
                continue
            size = FINENESS * r, FINENESS * layout.unit
            large = self._icon(2.0 * r)
            draw_robot(large, size[0], 0.5 * large.get_height(), 0.0, code, size)
            left += self._keep(large, left, y) + gap
            left += self._write(self._blank, name, left, y) + 2.5 * gap
        if self._stage.goals is not None:
            self._legend_of_goals()
            return
        large = self._icon(3.0 * r)
        width, height = large.get_size()
        ends = np.array([0.0, 0.6 * height]), np.array([width, 0.6 * height])
        draw_arc(large, *ends, round(1.5 * FINENESS * layout.unit))
        left += self._keep(large, left, y) + gap
        left += self._write(self._blank, "message", left, y) + 2.5 * gap
        if self._stage.has_faults:
            self._legend_of_faults(left, y)

    def _legend_of_goals(self) -> None:
        """What is drawn of goals, claims, estimates and lidar."""
        layout, y = self._layout, self._below(1)
        r, pixel = 0.45 * layout.text * FINENESS, FINENESS * layout.unit
        gap, left = 4.0 * layout.unit, float(layout.margin)
        for name in ("goal", "claimed rightly", "claimed wrongly", "believed", "lidar"):
            large = self._icon(2.4 * r / FINENESS)
            x, middle = 1.2 * r, 0.5 * large.get_height()
            if name == "goal":
                draw_goal(large, (x, middle), r, pixel)
            elif name == "claimed rightly":
                draw_right(large, x, middle, r)
            elif name == "claimed wrongly":
                draw_wrong(large, x, middle, r)
            elif name == "believed":
                axes = 1.15 * r, 0.7 * r
                draw_ellipse(large, np.array([x, middle]), axes, 0.5, round(1.2 * pixel))
            else:
                pygame.draw.circle(large, palette.LIDAR, (x, middle), r, round(1.2 * pixel))
            left += self._keep(large, left, y) + gap
            left += self._write(self._blank, name, left, y) + 2.5 * gap

    def _legend_of_faults(self, left: float, y: int) -> None:
        """How a faulty robot is marked."""
        layout = self._layout
        r = 0.45 * layout.text
        large = self._icon(2.0 * r)
        wide = max(1, round(1.2 * FINENESS * layout.unit))
        draw_fault_mark(large, FINENESS * r, 0.5 * large.get_height(), FINENESS * r, wide)
        left += self._keep(large, left, y) + 4.0 * layout.unit
        self._write(self._blank, "faulty", left, y)

    def _legend_of_beliefs(self) -> None:
        """What is drawn of the selected robot's beliefs."""
        layout, y = self._layout, self._below(self._layout.legend_lines + 1)
        if self._stage.goals is not None:
            text = self._letters.cut(ESTIMATE, layout.width - 2 * layout.margin)
            self._write(self._blank, text, layout.margin, y, palette.FAINT)
            return
        large = self._icon(layout.line)
        half = 0.5 * large.get_height()
        centre, radii = np.array([half, half]), (0.55 * half, 0.9 * half)
        draw_belief(large, centre, radii, palette.BLUE, 0.6 * FINENESS * layout.unit)
        left = layout.margin + self._keep(large, layout.margin, y) + 4.0 * layout.unit
        room = layout.width - layout.margin - left
        self._write(self._blank, self._letters.cut(BELIEF, room), left, y, palette.FAINT)

    def _icon(self, width: float) -> pygame.Surface:
        """A surface for something as high as a line of text, drawn large."""
        size = round(width * FINENESS), self._layout.line * FINENESS
        large = pygame.Surface(size, depth=32)
        large.fill(palette.PAGE)
        return large

    def _keep(self, large: pygame.Surface, x: float, y: float) -> int:
        """Put what was drawn large beside the text; its width."""
        size = large.get_width() // FINENESS, large.get_height() // FINENESS
        self._blank.blit(pygame.transform.smoothscale(large, size), (round(x), y))
        return size[0]

    def _told(self, scene: Scene, selected: int | None) -> str:
        """What the selected robot does and believes, in words."""
        if selected is None:
            return "No robot selected"
        is_faulty = scene.faulty is not None and scene.faulty[selected]
        doing = self._stage.states[scene.doing[selected]]
        words = [f"Robot {selected}: {doing}{', faulty' if is_faulty else ''}"]
        if scene.localised is not None:
            return "   ".join(words + _told_of_goal(scene, scene.localised, selected))
        for area, name in enumerate(("nest", "prey")):
            if scene.known[selected, area]:
                believed = scene.believed[selected, area]
                true = self._stage.nearest_area(area, believed, scene.time)
                off = np.hypot(*(believed - true))
                words.append(f"{name} {100 * off:.0f} cm off, p {scene.p[selected, area]:.2f} m")
            else:
                words.append(f"{name} unknown")
        return "   ".join(words)

    def _below(self, line: int) -> int:
        """Top of a line of text below the arena [px]."""
        layout = self._layout
        return layout.corner[1] + layout.arena[1] + layout.margin // 2 + line * layout.line

    def _write(
        self, on: pygame.Surface, text: str, x: float, y: float, ink: Colour = palette.INK
    ) -> int:
        """Write one line with its left edge at x; its width."""
        words = self._letters.line(text, ink)
        on.blit(words, (round(x), round(y) + (self._layout.line - words.get_height()) // 2))
        return words.get_width()


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


def _told_of_goal(scene: Scene, localised: Localised, robot: int) -> list[str]:
    """What a robot that visits goals believes, and has claimed, in words."""
    place = scene.pose[robot, :2]
    off = np.hypot(*(localised.believed[robot] - place))
    away = np.hypot(*(localised.goal[robot] - place))
    right, wrong = localised.right[robot], localised.wrong[robot]
    return [
        f"{100.0 * off:.0f} cm off, ellipse {100.0 * WITHIN * localised.ellipse[robot, 0]:.0f} cm",
        f"goal {away:.1f} m away",
        f"{right} claimed rightly, {wrong} wrongly",
    ]


def clock_text(seconds: float) -> str:
    """Minutes and seconds.

    >>> clock_text(754.2)
    '12:34'
    """
    minutes, rest = divmod(int(seconds + 1e-6), 60)
    return f"{minutes}:{rest:02d}"
