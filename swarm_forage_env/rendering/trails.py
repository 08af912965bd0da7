"""Trails: where the robots of a picture came from, and who was heard just now."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int8, Int32
from swarm_forage_env.scene import Scene

TRAIL = 20.0
"""Trails go back this far [s]."""

POINTS = 25
"""Points of a trail."""

JUST_NOW = 0.5
"""How long messages are drawn [s]: one tick would be missed between two pictures."""


@dataclass(frozen=True, slots=True)
class Claim:
    """A robot at `place` said that it was at its goal, which was judged at `time` [s], [m]."""

    time: float
    place: Float64[Array, " 2"]
    goal: Float64[Array, " 2"]
    is_right: bool


class Trails:
    """The recent past of one world, scene by scene."""

    def __init__(self) -> None:
        self._past: deque[Scene] = deque(maxlen=POINTS)
        self._heard: deque[Scene] = deque()
        self.claims: deque[Claim] = deque()
        """The recent claims, oldest first."""
        self._now = -1.0

    def take(self, scene: Scene) -> None:
        """Remember the next scene; at time 0, or when time runs backwards, an episode begins."""
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
        """Where the robots were, oldest first, and what they were doing there."""
        past = [scene for scene in self._past if scene.time > self._now - TRAIL - 1e-9]
        places = np.stack([scene.pose[:, :2] for scene in past])
        return places, np.stack([scene.doing for scene in past])

    def messages(self) -> Int32[Array, "messages ends"]:
        """Sender and receiver, once each, of what was heard just now."""
        heard = np.unique(np.concatenate([scene.messages for scene in self._heard]), axis=0)
        return np.asarray(heard.astype(np.int32))
