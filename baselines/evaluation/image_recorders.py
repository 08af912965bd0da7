"""Recorders that draw with pygame: a window, a video, a still."""

from collections.abc import Iterator
from contextlib import contextmanager

from baselines.evaluation.watch import Take, WatchOptions
from swarm_forage_env.rendering.layout import Layout
from swarm_forage_env.rendering.painter import Painter, Show
from swarm_forage_env.rendering.video import Video, fps_of
from swarm_forage_env.rendering.viewer import frame_of, save
from swarm_forage_env.rendering.window import Window
from swarm_forage_env.scene import Scene, Stage


@contextmanager
def live_window(stage: Stage, options: WatchOptions) -> Iterator[Take]:
    """Show the scenes in a window, from `options.start` on, until the user closes it."""
    window = Window(stage, options.size, options.speed, options.select)

    def take(scene: Scene) -> bool:
        if scene.time >= options.start - 1e-9:
            window.show(scene)
        else:
            window.take_past(scene)
        return window.closed

    try:
        yield take
    finally:
        window.close()


def painter_of(stage: Stage, options: WatchOptions) -> tuple[Painter, Show]:
    """Return the painter of the images and what it shows; beliefs only if a robot is selected."""
    layout = Layout(stage, options.size, beliefs=options.select is not None)
    return Painter(stage, layout), Show(selected=options.select)


@contextmanager
def still(stage: Stage, options: WatchOptions) -> Iterator[Take]:
    """Write the last scene as a PNG."""
    painter, show = painter_of(stage, options)
    last: Scene | None = None

    def take(scene: Scene) -> None:
        nonlocal last
        last = scene
        painter.take(scene)

    yield take
    if last is not None and options.frame is not None:
        save(painter.paint(last, show), options.frame)


@contextmanager
def video(stage: Stage, options: WatchOptions) -> Iterator[Take]:
    """Write a video at a multiple of real time. ConfigError if that fails."""
    assert options.video is not None
    painter, show = painter_of(stage, options)
    film = Video(options.video, painter.layout.width, painter.layout.height)
    every, due = options.speed / fps_of(options.video), options.start

    def take(scene: Scene) -> None:
        """Add all frames that are due; in slow motion one scene has several."""
        nonlocal due
        painter.take(scene)
        if scene.time >= due - 1e-9:
            frame = frame_of(painter.paint(scene, show, f"{options.speed:g}x"))
            while scene.time >= due - 1e-9:
                film.add(frame)
                due += every

    try:
        yield take
    except BaseException:  # also if the user interrupts: an incomplete video is discarded
        film.discard()
        raise
    film.close()
