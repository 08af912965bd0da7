"""Playground: a page that runs worlds in WebAssembly and draws them like a replay.

In place of a recording, the page holds machine code and the initial memory of a world. A worker
runs an episode when the page opens, and again whenever the seed or a parameter changes. A visitor
can take over a robot.
"""

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.replay import Opening, about_of, element_of, page_of, part
from swarm_forage_env.scene import Stage

Patch = tuple[int, bytes]
"""Offset in the memory of a world, and the bytes that replace its content there."""

ALLOWED = " 'wasm-unsafe-eval' blob:; worker-src blob:"
"""Additional permissions of the page: compile WebAssembly, in a worker."""


@dataclass(frozen=True)
class Slider:
    """Slider for a parameter."""

    name: str
    """Name of the parameter, as in `--set`."""
    label: str
    words: tuple[str, ...]
    """Displayed text of each value."""
    values: tuple[float, ...]
    usual: int
    """Index of the value in the scenario."""
    settings: tuple[tuple[str, ...], ...]
    """Arguments of `--set` for each value; empty for a parameter of the controller."""
    shown: tuple[Mapping[str, object], ...]
    """Changes of the stage data of the page for each value."""


@dataclass(frozen=True)
class ArrayPlace:
    """Array in the memory of a world; its size [byte] depends on the number of robots."""

    name: str
    fixed: int = 0
    per_robot: int = 0
    per_pair: int = 0
    is_kept: bool = False
    """Whether the image of the world holds the array; other arrays start as zeros."""
    same: str | None = None
    """Name of the array with which it shares its memory."""


@dataclass(frozen=True)
class Driving:
    """Layout of the record of a robot that a visitor drives, and of its observation."""

    size: int
    """Size of a record [byte]."""
    offset: int
    """Offset of the action in a record [byte]."""
    action: bytes
    """Action record that replaces the motion."""
    wheels: int
    """Offset of the wheel speeds in an action [byte]."""
    observed: Sequence[tuple[str, str, float]]
    """Name, unit and lower bound of each feature of an observation."""


@dataclass(frozen=True)
class Program:
    """Program of one swarm that runs in the page."""

    controller: str
    colour: str
    """Colour of the swarm, as `#rrggbb`."""
    code: bytes
    """WebAssembly module that exports `swarm_run`: `foraging.drawing.run_and_draw`, compiled."""
    image: bytes
    """Initial content of the arrays that are kept, one after the other."""
    arrays: Sequence[ArrayPlace]
    """All arrays, in the order of the arguments of `swarm_run`."""
    widths: Sequence[int]
    """Arguments of `swarm_run` after the number of robots: widths of arrays."""
    patches: Mapping[str, Sequence[Sequence[Patch]]]
    """Patches of the image for each value of a slider, by the name of the slider."""
    numbers: Sequence[str]
    """Names of the sliders that change a parameter of its controller."""
    driving: Driving

    def about(self) -> dict[str, object]:
        """Return the data of the program that the page needs."""
        return {
            "controller": self.controller,
            "colour": self.colour,
            "codeSize": len(self.code),
            "arrays": [asdict(each) for each in self.arrays],
            "widths": self.widths,
            "numbers": self.numbers,
            "driving": asdict(self.driving) | {"action": _text(self.driving.action)},
            "patches": {
                name: [[(at, _text(written)) for at, written in each] for each in several]
                for name, several in self.patches.items()
            },
        }


def _text(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def playground(  # noqa: PLR0913 what a page is made of
    stage: Stage,
    command: tuple[str, Sequence[str]],
    programs: Sequence[Program],
    sliders: Sequence[Slider],
    columns: Sequence[str],
    every: int,
    replays: Sequence[Recording],
) -> str:
    """Return the HTML page; programs write the `columns` of every robot each `every` ticks.

    `command` is the command line for the same episode, up to its controllers and after them.
    `replays`, one per program, are shown if the browser has no WebAssembly.
    """
    ticks = round(stage.duration / stage.tick)
    packs = [recording.pack() for recording in replays]
    others = [f'<script type="text/plain" id="machine">{part("machine.js")}</script>']
    others += [element_of(f"replay-{k}", packed) for k, (_, packed) in enumerate(packs)]
    about = about_of(stage, "", Opening()) | {
        "frames": -(-ticks // every) + 1,
        "every": every,
        "columns": [{"name": name} for name in columns],
        "hasFaults": stage.has_faults,
        "live": {
            "ticks": ticks,
            "columns": columns,
            "command": command,
            "sliders": [asdict(each) for each in sliders],
            "replays": [about | {"every": every} for about, _ in packs],
        },
    }
    names = " and ".join(each.controller for each in programs)
    return page_of(
        f"{stage.scenario} · {names}",
        about,
        [each.about() for each in programs],
        [zlib.compress(each.code + each.image, 9) for each in programs],
        ALLOWED,
        "\n".join(others),
    )
