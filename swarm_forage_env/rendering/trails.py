"""Trails: recent positions, messages and claims of the robots of a picture."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int8, Int32
from swarm_forage_env.scene import Scene

TRAIL = 20.0
"""Duration of a trail [s]."""

POINTS = 25
"""Number of points of a trail."""

JUST_NOW = 0.5
"""Time for which messages are drawn [s]: those of one tick could fall between two pictures."""


@dataclass(frozen=True, slots=True)
class Claim:
    """Claim of a robot at `place` [m] to be at its goal, judged at `time` [s]."""

    time: float
    place: Float64[Array, " 2"]
    goal: Float64[Array, " 2"]
    is_right: bool


class Trails:
    """Recent scenes of one world."""

    def __init__(self) -> None:
        self._past: deque[Scene] = deque(maxlen=POINTS)
        self._heard: deque[Scene] = deque()
        self.claims: deque[Claim] = deque()
        """Recent claims, oldest first."""
        self._now = -1.0

    def take(self, scene: Scene) -> None:
        """Add the next scene; a scene at time 0 or before the last one begins an episode."""
        if scene.time < self._now or scene.time == 0.0:
            self._past.clear()
            self._heard.clear()
            self.claims.clear()
        self._take_claims(scene)
        self._now = scene.time
        if not self._past or scene.time - self._past[-1].time > TRAIL / POINTS - 1e-9:
            self._past.append(scene)
        self._heard.append(scene)
        while self._heard[0].time < scene.time - JUST_NOW + 1e-9:
            self._heard.popleft()

    def _take_claims(self, scene: Scene) -> None:
        before = self._heard[-1] if self._heard else scene
        now, then = scene.localised, before.localised
        if now is None or then is None:
            return
        for is_right, new in ((True, now.right > then.right), (False, now.wrong > then.wrong)):
            for robot in np.flatnonzero(new):
                place, goal = before.pose[robot, :2], then.goal[robot]
                self.claims.append(Claim(scene.time, place, goal, is_right))
        while self.claims and self.claims[0].time < scene.time - TRAIL + 1e-9:
            self.claims.popleft()

    def trails(self) -> tuple[Float64[Array, "points robots 2"], Int8[Array, "points robots"]]:
        """Return the recent positions of the robots, oldest first, and their states there."""
        past = [scene for scene in self._past if scene.time > self._now - TRAIL - 1e-9]
        places = np.stack([scene.pose[:, :2] for scene in past])
        return places, np.stack([scene.activity for scene in past])

    def messages(self) -> Int32[Array, "messages ends"]:
        """Return sender and receiver of each distinct recent message."""
        heard = np.unique(np.concatenate([scene.messages for scene in self._heard]), axis=0)
        return np.asarray(heard.astype(np.int32))
