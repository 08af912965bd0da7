"""Video: writes frames to an MP4 or an animated GIF with the ffmpeg of imageio-ffmpeg."""

import subprocess
from pathlib import Path

from swarm_forage_env.arrays import Array, UInt8
from swarm_forage_env.atomic_write import replacing, temporary_of
from swarm_forage_env.errors import ConfigError

FPS = 30
"""Frames per second of an MP4."""

GIF_FPS = 12
"""Frames per second of a GIF, which stores almost every whole frame."""

FORMATS = (".mp4", ".gif")

ONE_PALETTE = "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=none"
"""Filter for one palette of 256 colours for all frames of a GIF, without dithering."""


def fps_of(file: Path) -> int:
    """Return the frames per second of a video file."""
    return GIF_FPS if file.suffix.lower() == ".gif" else FPS


FLAGS = {
    ".mp4": "-c:v h264 -crf 20 -pix_fmt yuv420p -vf scale=ceil(iw/2)*2:ceil(ih/2)*2"
    " -movflags +faststart -f mp4",
    ".gif": f"-c:v gif -pix_fmt pal8 -filter_complex {ONE_PALETTE} -loop 0 -f gif",
}
"""Options of ffmpeg for each format; H.264 in yuv420p needs an even width and height."""


class Video:
    """Writer of frames of one size to a video file, which appears when the writer is closed.

    ConfigError without ffmpeg. Ctrl-C does not reach ffmpeg: the calling process ends it.
    """

    def __init__(self, file: Path, width: int, height: int) -> None:
        import imageio_ffmpeg

        self._file, self._trial = file, temporary_of(file)
        frames = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps_of(file)} -i -"
        try:
            program = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "quiet", *frames.split()]
            program += [*FLAGS[file.suffix.lower()].split(), str(self._trial)]
            self._ffmpeg = subprocess.Popen(
                program,
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except (OSError, RuntimeError):
            raise ConfigError(
                f"{file}: no ffmpeg was found to write it; pip install 'swarm-forage[render]'"
                " installs one, or set the environment variable IMAGEIO_FFMPEG_EXE to the path"
                " of yours"
            ) from None
        assert self._ffmpeg.stdin is not None
        self._frames = self._ffmpeg.stdin

    def add(self, frame: UInt8[Array, "height width 3"]) -> None:
        """Write the next frame. ConfigError if ffmpeg fails."""
        left = memoryview(frame.tobytes())
        try:
            while left:
                left = left[self._frames.write(left) :]
        except OSError:
            raise self._refusal() from None

    def close(self) -> None:
        """Finish the file and rename it to its final name. ConfigError if ffmpeg fails."""
        with replacing(self._file):
            if self._end() != 0:
                raise self._refusal()

    def discard(self) -> None:
        """Stop ffmpeg and delete the unfinished file."""
        self._ffmpeg.kill()
        self._end()
        self._trial.unlink(missing_ok=True)

    def _end(self) -> int:
        """Close the input of ffmpeg and return its exit status."""
        self._frames.close()
        return self._ffmpeg.wait()

    def _refusal(self) -> ConfigError:
        return ConfigError(
            f"{self._file}: cannot be written; ffmpeg stopped early, perhaps because the disk is"
            " full"
        )
