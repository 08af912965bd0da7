"""A playground: a page that runs its worlds itself, in WebAssembly, and draws them as a replay.

The page is that of a replay. Where a replay has the recording of a swarm, this one has machine code
and the first bytes of a world for each seed; a worker runs an episode of it when the page opens,
and whenever the seed or a number is changed by a slider.
"""

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from swarm_forage_env.rendering.replay import Opening, about_of, page_of, part
from swarm_forage_env.scene import Stage

Patch = tuple[int, bytes]
"""Bytes that stand in the memory of a world instead, and where."""

ALLOWED = " 'wasm-unsafe-eval' blob:; worker-src blob:"
"""What the page may do beside: compile WebAssembly, in a worker."""


@dataclass(frozen=True)
class Slider:
    """A number that the visitor changes."""

    name: str
    """Of the parameter, as in `--set`."""
    label: str
    unit: str
    values: tuple[float, ...]
    usual: int
    """Which of the values is the scenario's."""


@dataclass(frozen=True)
class Program:
    """A swarm whose world runs in the page."""

    controller: str
    colour: str
    """As `#rrggbb`."""
    code: bytes
    """A module of WebAssembly that exports `swarm_run`, of `foraging.drawing.run_and_draw`."""
    images: Sequence[bytes]
    """The memory of a world that is about to begin, for each seed."""
    sizes: tuple[int, ...]
    """Of the arrays of which a memory consists [byte]."""
    patches: Mapping[str, Sequence[Sequence[Patch]]]
    """What each value of a slider writes into the memory, by the slider's name."""

    def about(self) -> dict[str, object]:
        """What the page must know of it."""
        return {
            "controller": self.controller,
            "colour": self.colour,
            "sizes": self.sizes,
            "codeSize": len(self.code),
            "patches": {
                name: [
                    [(at, base64.b64encode(written).decode("ascii")) for at, written in each]
                    for each in several
                ]
                for name, several in self.patches.items()
            },
        }


def playground(
    stage: Stage,
    command: str,
    programs: Sequence[Program],
    sliders: Sequence[Slider],
    columns: Sequence[str],
    every: int,
) -> str:
    """The HTML page; `columns` are what a program writes of a robot, `every` so many ticks."""
    ticks, most_heard = round(stage.duration / stage.tick), stage.n_robots * (stage.n_robots - 1)
    shown = [each for each in columns if each != "faulty" or stage.has_faults]
    about = about_of(stage, command, Opening()) | {
        "seed": 0,
        "frames": -(-ticks // every) + 1,
        "every": every,
        "columns": [{"name": name} for name in shown],
        "live": {
            "ticks": ticks,
            "columns": columns,
            "heard": every * most_heard,
            "seeds": len(programs[0].images),
            "sliders": [asdict(each) for each in sliders],
        },
    }
    names = " and ".join(each.controller for each in programs)
    return page_of(
        f"{stage.scenario} · {names}",
        about,
        [each.about() for each in programs],
        [zlib.compress(each.code + b"".join(each.images), 9) for each in programs],
        ALLOWED,
        f'<script type="text/plain" id="machine">{part("machine.js")}</script>',
    )
