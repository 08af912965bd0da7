"""Frames: the last observations of every robot together, as `stack` asks for them."""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Int64

Seen = Float32[Array, "worlds robots numbers"]


class Frames:
    """The last observations of every robot, the oldest first; a single one is not kept."""

    def __init__(self, shape: tuple[int, int], stack: int, n_numbers: int) -> None:
        """So many observations of so many numbers; of worlds by robots."""
        kept = (*shape, stack, n_numbers)
        self._kept = np.zeros(kept, np.float32) if stack > 1 else None

    def begin(self, seen: Seen, worlds: Int64[Array, " chosen"]) -> Seen:
        """All frames, in these worlds the first observation of an episode alone."""
        if self._kept is None:
            return seen
        self._kept[worlds] = seen[worlds, :, None]
        return self._joined()

    def add(self, seen: Seen, worlds: slice | Int64[Array, " chosen"] = slice(None)) -> Seen:
        """All frames, in these worlds with an observation more and without the oldest."""
        if self._kept is None:
            return seen
        self._kept[worlds, :, :-1] = self._kept[worlds, :, 1:]
        self._kept[worlds, :, -1] = seen[worlds]
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
