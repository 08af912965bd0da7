"""Frames: the last observations of every robot together, as `stack` asks for them."""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.compiler import entry_point, inlined

Seen = Float32[Array, "worlds robots numbers"]


@inlined
def fill_frames(kept: Float32[Array, "frames numbers"], seen: Float32[Array, " numbers"]) -> None:
    """Make an observation all frames of a robot."""
    for frame in range(kept.shape[0]):
        for k in range(kept.shape[1]):
            kept[frame, k] = seen[k]


@inlined
def push_frame(kept: Float32[Array, "frames numbers"], seen: Float32[Array, " numbers"]) -> None:
    """Add an observation to the frames of a robot, and drop the oldest."""
    last = kept.shape[0] - 1
    for frame in range(last):
        for k in range(kept.shape[1]):
            kept[frame, k] = kept[frame + 1, k]
    for k in range(kept.shape[1]):
        kept[last, k] = seen[k]


@entry_point
def update_frames(
    kept: Float32[Array, "worlds robots frames numbers"],
    seen: Float32[Array, "worlds robots numbers"],
    chosen: Int64[Array, " chosen"],
    begins: bool,
) -> None:
    """Add an observation to the frames of all robots of some worlds, or make it all of them."""
    for w in chosen:
        for i in range(kept.shape[1]):
            if begins:
                fill_frames(kept[w, i], seen[w, i])
            else:
                push_frame(kept[w, i], seen[w, i])


class Frames:
    """The last observations of every robot, the oldest first; a single one is not kept."""

    def __init__(self, shape: tuple[int, int], stack: int, n_numbers: int) -> None:
        """So many observations of so many numbers; of worlds by robots."""
        kept = (*shape, stack, n_numbers)
        self._all = np.arange(shape[0])
        self._kept = np.zeros(kept, np.float32) if stack > 1 else None

    def begin(self, seen: Seen, worlds: Int64[Array, " chosen"]) -> Seen:
        """All frames, in these worlds the first observation of an episode alone."""
        if self._kept is None:
            return seen
        update_frames(self._kept, seen, worlds, True)
        return self._joined()

    def add(self, seen: Seen, worlds: Int64[Array, " chosen"] | None = None) -> Seen:
        """All frames, in these worlds or all with an observation more and without the oldest."""
        if self._kept is None:
            return seen
        update_frames(self._kept, seen, self._all if worlds is None else worlds, False)
        return self._joined()

    def fits(self, kept: Any) -> bool:  # noqa: ANN401 of `snapshot`
        """The snapshot is of as many worlds, robots, observations and numbers."""
        shapes = [None if each is None else each.shape for each in (kept, self._kept)]
        return bool(shapes[0] == shapes[1])

    def snapshot(self) -> Any:  # noqa: ANN401 for `restore` alone
        """What a later `restore` needs."""
        return None if self._kept is None else self._kept.copy()

    def restore(self, kept: Any) -> None:  # noqa: ANN401 of `snapshot`
        """Go on as when the snapshot was taken."""
        if self._kept is not None:
            self._kept[...] = kept

    def _joined(self) -> Seen:
        assert self._kept is not None
        return self._kept.reshape(*self._kept.shape[:2], -1).copy()
