"""Recorders that paint, with pygame: a window, a video, a still."""

from pathlib import Path

from baselines.evaluation.watch import Recorder
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.frame import frame_of, save
from swarm_forage_env.rendering.layout import Layout, checked_size
from swarm_forage_env.rendering.painter import Painter, Show
from swarm_forage_env.rendering.video import Video, fps_of
from swarm_forage_env.rendering.window import Window
from swarm_forage_env.scene import Scene, Stage


class LiveWindow(Recorder):
    """A window that shows the scenes as they come."""

    def __init__(self, window: Window, start: float) -> None:
        """Use this window; it opens with the first scene."""
        self._window, self._start = window, start

    def take(self, scene: Scene) -> bool:
        """Show the scene; return false once the user has closed the window."""
        if scene.time >= self._start - 1e-9:
            self._window.show(scene)
        else:
            self._window.take_past(scene)
        return not self._window.closed

    def close(self) -> None:
        """Close the window."""
        self._window.close()

    discard = close


class ImageRecorder(Recorder):
    """Base of the recorders that paint scenes into a file."""

    def __init__(self, file: Path, stage: Stage, size: int, select: int | None) -> None:
        """Paint images of this width, with the beliefs of the selected robot if any."""
        self._file = file
        self._layout = Layout(stage, checked_size(size), beliefs=select is not None)
        self._painter = Painter(stage, self._layout)
        self._show = Show(selected=select)


class StillRecorder(ImageRecorder):
    """Writes the last scene as a PNG."""

    _scene: Scene | None = None

    def take(self, scene: Scene) -> bool:
        """Remember the scene."""
        self._scene = scene
        self._painter.take(scene)
        return True

    def close(self) -> None:
        """Paint and write the last scene. ConfigError where that fails."""
        if self._scene is None:
            return
        picture = self._painter.paint(self._scene, self._show)
        try:
            save(picture, self._file)
        except OSError as error:
            raise ConfigError(
                f"--frame {self._file}: cannot be written ({error.strerror})"
            ) from None


class VideoRecorder(ImageRecorder):
    """Writes a video at a multiple of real time."""

    def __init__(
        self, file: Path, stage: Stage, size: int, select: int | None, speed: float, start: float
    ) -> None:
        """Open the video file. ConfigError where there is no ffmpeg."""
        super().__init__(file, stage, size, select)
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
        """Finish the video file."""
        self._video.close()

    def discard(self) -> None:
        """Delete the unfinished video."""
        self._video.discard()
