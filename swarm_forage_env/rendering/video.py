"""Video: frames to an MP4 or an animated GIF, by the ffmpeg that imageio-ffmpeg brings."""

import os
from pathlib import Path
from typing import Any

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.errors import ConfigError

FPS = 30
"""Frames in a second of an MP4."""

GIF_FPS = 12
"""Frames in a second of a GIF, which stores every one almost whole."""

FORMATS = (".mp4", ".gif")

ONE_PALETTE = "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=none"
"""A GIF has 256 colours: those of all frames together, without speckles."""


def fps_of(file: Path) -> int:
    """Frames in a second of a video."""
    return GIF_FPS if file.suffix.lower() == ".gif" else FPS


class Video:
    """Writes frames of one size to a file, which appears when it is closed."""

    def __init__(self, file: Path, width: int, height: int) -> None:
        """ConfigError where there is no ffmpeg."""
        import imageio_ffmpeg

        self._file = file
        self._trial = file.with_name(f".{file.stem}.{os.getpid()}{file.suffix}")
        options: dict[str, Any] = {"quality": 6, "output_params": ["-movflags", "+faststart"]}
        if file.suffix.lower() == ".gif":
            options = {
                "codec": "gif", "quality": None, "pix_fmt_out": "pal8",
                "output_params": ["-filter_complex", ONE_PALETTE, "-loop", "0"],
            }  # fmt: skip
        self._frames = imageio_ffmpeg.write_frames(
            str(self._trial), (width, height), fps=fps_of(file), macro_block_size=2,
            ffmpeg_log_level="error", **options,
        )  # fmt: skip
        try:
            self._frames.send(None)
        except (OSError, RuntimeError):
            raise ConfigError(
                f"{file}: no ffmpeg was found to write it; pip install 'swarm-forage[render]'"
                " brings one, or name yours in the variable IMAGEIO_FFMPEG_EXE"
            ) from None

    def add(self, frame: UInt8[Array, "height width 3"]) -> None:
        """Write the next frame. ConfigError where ffmpeg gives up."""
        try:
            self._frames.send(frame)
        except OSError as error:
            raise ConfigError(f"{self._file}: cannot be written; {_reason(error)}") from None

    def close(self) -> None:
        """Finish the file and give it its name."""
        self._frames.close()
        self._trial.replace(self._file)

    def discard(self) -> None:
        """Stop, and leave nothing behind."""
        self._frames.close()
        self._trial.unlink(missing_ok=True)


def _reason(error: OSError) -> str:
    """The last thing ffmpeg said."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else "ffmpeg stopped"
