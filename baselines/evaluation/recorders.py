"""Recorders of a watched episode: what they are, and that of a replay."""

from pathlib import Path
from typing import Protocol

from swarm_forage_env.rendering.replay import Replay
from swarm_forage_env.scene import Scene


class Recorder(Protocol):
    """Protocol of what receives an episode's scenes; those before `start` are for trails only."""

    def take(self, scene: Scene) -> bool:
        """Receive the next scene; return false to stop the episode."""
        ...

    def close(self) -> None:
        """Finish after the last scene."""
        ...

    def discard(self) -> None:
        """Remove what is half-made, after an error."""
        ...


class ReplayRecorder:
    """Writes a replay as one HTML file."""

    def __init__(self, file: Path, replay: Replay) -> None:
        """Start with an empty recording."""
        self._file = file
        self._replay = replay

    def take(self, scene: Scene) -> bool:
        """Record the scene."""
        self._replay.add(scene)
        return True

    def close(self) -> None:
        """Write the HTML file."""
        self._replay.write(self._file)

    def discard(self) -> None:
        """Do nothing: no file was written yet."""


class SecondSwarm:
    """Adds the scenes of a second swarm to a replay, which another recorder writes."""

    def __init__(self, replay: Replay) -> None:
        """Take the scenes of the swarm that is shown beside the first."""
        self._replay = replay

    def take(self, scene: Scene) -> bool:
        """Record the scene."""
        self._replay.add(scene, 1)
        return True

    def close(self) -> None:
        """Do nothing: the first swarm's recorder writes the page."""

    def discard(self) -> None:
        """Do nothing: no file was written yet."""
