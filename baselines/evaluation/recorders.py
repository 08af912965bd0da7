"""Recorders of a watched episode: what they are, and that of a replay."""

from abc import ABC, abstractmethod
from pathlib import Path

from swarm_forage_env.rendering.replay import Replay
from swarm_forage_env.scene import Scene


class Recorder(ABC):
    """Receives an episode's scenes; those before `start` are for trails only."""

    @abstractmethod
    def take(self, scene: Scene) -> bool:
        """Receive the next scene; return false to stop the episode."""

    def close(self) -> None:  # noqa: B027 some have nothing to finish
        """Finish after the last scene."""

    def discard(self) -> None:  # noqa: B027 some have written nothing yet
        """Remove what is half-made, after an error."""


class ReplayRecorder(Recorder):
    """Adds the scenes of a swarm to a replay, and writes it as one HTML file if it is the first."""

    def __init__(self, file: Path, replay: Replay, swarm: int = 0) -> None:
        """Start with an empty recording."""
        self._file, self._replay, self._swarm = file, replay, swarm

    def take(self, scene: Scene) -> bool:
        """Record the scene."""
        self._replay.add(scene, self._swarm)
        return True

    def close(self) -> None:
        """Write the HTML file."""
        if self._swarm == 0:
            self._replay.write(self._file)
