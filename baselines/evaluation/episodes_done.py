"""How many episodes of a plan are done, parts of one included, while its blocks still run."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from swarm_forage_env.loop import Loop

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PERIOD = 0.25
"""Between two looks at how far the blocks have come [s]."""


@dataclass(frozen=True)
class EpisodesDone:
    """A file with a number for each block: the episodes done of it, written by its worker."""

    file: Path

    def begin(self, n_blocks: int) -> None:
        """Make the file; nothing is done."""
        self.file.write_bytes(np.zeros(n_blocks).tobytes())

    @property
    def total(self) -> float:
        """The episodes done of all blocks; none before they begin."""
        return float(np.fromfile(self.file).sum()) if self.file.exists() else 0.0

    def of_block(self, number: int) -> "BlockDone":
        """What the worker of a block is handed."""
        return BlockDone(self.file, number)


@dataclass(frozen=True)
class BlockDone:
    """The number of one block in that file."""

    file: Path
    number: int

    def observer(self, n_episodes: int, n_ticks: int) -> Callable[[Loop], None]:
        """What is shown the worlds of the block, at the start and after every tick."""
        done, ticks = np.memmap(self.file, np.float64, "r+"), count()

        def observe(loop: Loop) -> None:
            done[self.number] = n_episodes * next(ticks) / n_ticks

        return observe


@contextmanager
def shown(done: EpisodesDone, progress: "Progress", bar: "TaskID") -> Iterator[None]:
    """Let a bar follow what is done, from a thread of its own."""
    is_over = threading.Event()

    def follow() -> None:
        while not is_over.wait(PERIOD):
            progress.update(bar, completed=done.total)

    thread = threading.Thread(target=follow, daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()
        progress.update(bar, completed=done.total)
