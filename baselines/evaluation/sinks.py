"""Where a watched episode goes: a window, a video, a still, a replay. Each takes scenes."""

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.layout import Layout, checked_size
from swarm_forage_env.rendering.painter import Painter, Show
from swarm_forage_env.rendering.scene import Scene, Stage
from swarm_forage_env.rendering.video import Video, fps_of
from swarm_forage_env.rendering.view import frame_of, save
from swarm_forage_env.rendering.window import Window

if TYPE_CHECKING:
    from swarm_forage_env.rendering.replay import Replay


class Sink(Protocol):
    """What an episode is shown on. Scenes before `start` are there for trails only."""

    def take(self, scene: Scene) -> bool:
        """Take the next scene; false when there is nobody to see any more."""
        ...

    def close(self) -> None:
        """The last scene was taken."""
        ...

    def discard(self) -> None:
        """Something went wrong: leave nothing half-made behind."""
        ...


class WindowSink:
    """A live window."""

    def __init__(self, window: Window, start: float) -> None:
        """It opens with the first scene."""
        self._window = window
        self._start = start

    def take(self, scene: Scene) -> bool:
        """Show it."""
        if scene.time >= self._start - 1e-9:
            self._window.show(scene)
        return not self._window.closed

    def close(self) -> None:
        """Close the window."""
        self._window.close()

    discard = close


class PictureSink:
    """Paints scenes for a file."""

    def __init__(self, stage: Stage, size: int, select: int | None) -> None:
        """Pictures of this width, with the beliefs of a robot if one is selected."""
        self._layout = Layout(stage, checked_size(size), beliefs=select is not None)
        self._painter = Painter(stage, self._layout)
        self._show = Show(selected=select)

    def discard(self) -> None:
        """Nothing was written yet."""


class StillSink(PictureSink):
    """The last scene, as a PNG."""

    _scene: Scene | None = None

    def __init__(self, file: Path, stage: Stage, size: int, select: int | None) -> None:
        """Nothing to write yet."""
        super().__init__(stage, size, select)
        self._file = file

    def take(self, scene: Scene) -> bool:
        """Remember it."""
        self._scene = scene
        self._painter.take(scene)
        return True

    def close(self) -> None:
        """Paint and write the last one. ConfigError where that fails."""
        if self._scene is None:
            return
        picture = self._painter.paint(self._scene, self._show)
        try:
            save(picture, self._file)
        except OSError as error:
            raise ConfigError(f"--frame {self._file}: cannot be written ({error})") from None


class VideoSink(PictureSink):
    """A film, at a multiple of real time."""

    def __init__(
        self, file: Path, stage: Stage, size: int, select: int | None, speed: float, start: float
    ) -> None:
        """A file of no frames yet. ConfigError where there is no ffmpeg."""
        super().__init__(stage, size, select)
        self._video = Video(file, self._layout.width, self._layout.height)
        self._speed = speed
        self._every = speed / fps_of(file)
        self._start = start
        self._made = 0

    def take(self, scene: Scene) -> bool:
        """Add as many frames as are due, the same one again where time is slow."""
        self._painter.take(scene)
        due = self._start + self._made * self._every
        if scene.time >= due - 1e-9:
            frame = frame_of(self._painter.paint(scene, self._show, f"{self._speed:g}x"))
            while scene.time >= self._start + self._made * self._every - 1e-9:
                self._video.add(frame)
                self._made += 1
        return True

    def close(self) -> None:
        """Finish the file."""
        self._video.close()

    def discard(self) -> None:
        """Leave nothing behind."""
        self._video.discard()


class ReplaySink:
    """One HTML file."""

    def __init__(self, file: Path, replay: "Replay", start: float) -> None:
        """Nothing recorded yet."""
        self._file = file
        self._replay = replay
        self._start = start

    def take(self, scene: Scene) -> bool:
        """Record it."""
        if scene.time >= self._start - 1e-9:
            self._replay.add(scene)
        return True

    def close(self) -> None:
        """Write the file."""
        self._replay.write(self._file)

    def discard(self) -> None:
        """Nothing was written yet."""
