"""Window: shows scenes live, at a multiple of real time, with keys."""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote

import pygame

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.layout import SPEEDS, Layout
from swarm_forage_env.rendering.painter import Painter, Show
from swarm_forage_env.rendering.viewer import save
from swarm_forage_env.scene import Scene, Stage

FPS = 30
"""Maximum number of pictures per second of real time."""

BEHIND = 0.25
"""Delay beyond which the window no longer catches up with its speed [s]."""

NOTICE = 2.0
"""Time for which a notice is shown above the arena [s]."""

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
"""Variables that name a display on Linux; without them SDL opens an invisible window."""


class Window:
    """Window on the screen, which opens with the first scene.

    Scenes before the time of the next picture are added to the trails, but not drawn.
    ConfigError if the width is out of bounds.
    """

    def __init__(
        self, stage: Stage, width: int, speed: float = 1.0, select: int | None = None
    ) -> None:
        self.speed = speed
        self.show_what = Show(selected=select)
        self.paused = self.closed = self._one_step = False
        self._stage = stage
        self._layout = Layout(stage, width, beliefs=True, keys=True)
        self._painter = Painter(stage, self._layout)
        self._screen: pygame.Surface | None = None
        self._scene: Scene | None = None
        self._due = 0.0
        self._anchor = 0.0, 0.0
        self._notice = "", 0.0
        self._driven: int | None = None
        self._held: set[int] = set()

    def drive(self, robot: int) -> None:
        """Reserve the arrow keys for driving this robot, and select it."""
        self._driven = self.show_what.selected = robot

    @property
    def arrows(self) -> tuple[bool, bool, bool]:
        """Whether the arrow keys up, left and right are held down."""
        up, left, right = (key in self._held for key in ARROWS)
        return up, left, right

    def show(self, scene: Scene) -> None:
        """Wait for the time of a scene, handling events, and draw it; blocks while paused.

        Has no effect if the window is closed or the scene has been shown. ConfigError without a
        display.
        """
        before = self._scene
        if self.closed:
            return
        is_first = before is None or scene.time < before.time or scene.time == 0.0
        if before is not None and scene.time == before.time and not is_first:
            return
        self._scene = scene
        self._painter.take(scene)
        if is_first:
            self._begin()
        elif scene.time < self._due - 1e-9:
            return
        self._due = scene.time + self.speed / FPS
        self._wait_for(scene)
        self._draw()
        while self._waits():
            time.sleep(1.0 / FPS)
            self._answer()
            self._draw()
            self._set_clock()
        if self._one_step:
            self._one_step = False
            self._due = 0.0

    def take_past(self, scene: Scene) -> None:
        """Add a scene to the trails without showing it."""
        self._painter.take(scene)

    def close(self) -> None:
        """Close the window; further calls have no effect."""
        if self._screen is not None:
            pygame.display.quit()
        self._screen = None
        self.closed = True

    def _begin(self) -> None:
        self._set_clock()
        if self._screen is not None:
            return
        if sys.platform == "linux" and not any(map(os.environ.get, DISPLAYS)):
            raise _no_display("DISPLAY is not set")
        try:
            pygame.display.init()
            self._screen = pygame.display.set_mode((self._layout.width, self._layout.height))
        except pygame.error as error:
            raise _no_display(str(error)) from None
        pygame.display.set_caption(f"{self._stage.scenario} {self._stage.controller}")

    def _wait_for(self, scene: Scene) -> None:
        """Sleep until the time of a scene, handling events about FPS times per second."""
        while not self.closed:
            self._answer()
            wall, then = self._anchor
            early = wall + (scene.time - then) / self.speed - time.perf_counter()
            if early < -BEHIND:
                self._set_clock()
            if early <= 0.0:
                return
            time.sleep(min(early, 1.0 / FPS))

    def _waits(self) -> bool:
        return self.paused and not self.closed and not self._one_step

    def _set_clock(self) -> None:
        if self._scene is not None:
            self._anchor = time.perf_counter(), self._scene.time

    def _draw(self) -> None:
        if self._screen is None or self._scene is None:
            return
        words, until = self._notice
        note = words if time.perf_counter() < until else f"{self.speed:g}x"
        note = f"paused   {note}" if self.paused else note
        if self._driven is not None:
            note = f"arrows drive robot {self._driven}   {note}"
        self._screen.blit(self._painter.paint(self._scene, self.show_what, note), (0, 0))
        pygame.display.flip()

    def _answer(self) -> None:
        for event in pygame.event.get() if self._screen is not None else ():
            if event.type == pygame.QUIT:
                self.close()
                return
            if event.type == pygame.MOUSEBUTTONDOWN and event.button == 1:
                self._select_at(event.pos)
            elif self._hold(event):
                continue
            elif event.type == pygame.KEYDOWN and event.key in KEYS:
                KEYS[event.key](self)
                if self.closed:
                    return

    def _hold(self, event: pygame.event.Event) -> bool:
        """Record a pressed or released arrow key; returns whether this consumes the event."""
        if event.type == pygame.WINDOWFOCUSLOST:
            self._held.clear()
        if event.type not in (pygame.KEYDOWN, pygame.KEYUP) or event.key not in ARROWS:
            return False
        (self._held.add if event.type == pygame.KEYDOWN else self._held.discard)(event.key)
        return self._driven is not None

    def _pause(self) -> None:
        self.paused = not self.paused

    def _step(self) -> None:
        self.paused = self._one_step = True

    def _change_speed(self, factor: float) -> None:
        self.speed = min(max(factor * self.speed, SPEEDS[0]), SPEEDS[1])
        self._set_clock()

    def _select_next(self) -> None:
        back = bool(pygame.key.get_mods() & pygame.KMOD_SHIFT)
        now, n = self.show_what.selected, self._stage.n_robots
        first = n - 1 if back else 0
        self.show_what.selected = first if now is None else (now + (-1 if back else 1)) % n

    def _select_none(self) -> None:
        self.show_what.selected = None

    def _toggle(self, field: str) -> None:
        switches = vars(self.show_what)
        switches[field] = not switches[field]

    def _select_at(self, spot: tuple[int, int]) -> None:
        if self._scene is not None:
            places = self._layout.in_picture(self._scene.pose[:, :2])
            away = ((places - spot) ** 2).sum(axis=1) ** 0.5
            near = int(away.argmin())
            hit = away[near] <= self._layout.robot_radius + 4.0
            self.show_what.selected = near if hit else None

    def _save(self) -> None:
        """Write the current picture to a PNG in the current folder."""
        if self._scene is None:
            return
        name = quote(self._stage.scenario, safe="")
        file = Path(f"{name}-{self._scene.time:07.1f}s.png")
        words = f"saved {file}"
        try:
            save(self._painter.paint(self._scene, self.show_what, f"{self.speed:g}x"), file)
        except OSError:
            words = f"cannot write {file}"
        self._notice = words, time.perf_counter() + NOTICE


def _no_display(reason: str) -> ConfigError:
    return ConfigError(
        f"no window: there is no display to open it on ({reason}); make frames, a video or a"
        " replay instead: render_mode='rgb_array', --frame, --video or --html"
    )


ARROWS = (pygame.K_UP, pygame.K_LEFT, pygame.K_RIGHT)
"""Keys that drive a robot: ahead, left, right."""

FASTER = (pygame.K_PLUS, pygame.K_EQUALS, pygame.K_KP_PLUS)
SLOWER = (pygame.K_MINUS, pygame.K_KP_MINUS)

KEYS: dict[int, Callable[[Window], None]] = {
    pygame.K_SPACE: Window._pause,
    pygame.K_PERIOD: Window._step,
    pygame.K_RIGHT: Window._step,
    **dict.fromkeys(FASTER, lambda window: window._change_speed(2.0)),
    **dict.fromkeys(SLOWER, lambda window: window._change_speed(0.5)),
    pygame.K_TAB: Window._select_next,
    pygame.K_ESCAPE: Window._select_none,
    pygame.K_t: lambda window: window._toggle("trails"),
    pygame.K_b: lambda window: window._toggle("beliefs"),
    pygame.K_m: lambda window: window._toggle("messages"),
    pygame.K_s: Window._save,
    pygame.K_q: Window.close,
}
"""Action of each key; `hud.HELP` lists them for the user."""
