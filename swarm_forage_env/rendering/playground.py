"""A playground: a page that runs its worlds itself, in WebAssembly, and draws them as a replay.

Where a replay has the recording of a swarm, this page has machine code and the memory of a world
that begins; a worker runs an episode of it when the page opens, and whenever the seed or a number
is changed. A visitor can take over a robot.
"""

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.replay import Opening, about_of, element_of, page_of, part
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
    words: tuple[str, ...]
    """The values as they are shown."""
    values: tuple[float, ...]
    usual: int
    """Which of the values is the scenario's."""
    settings: tuple[tuple[str, ...], ...]
    """What makes each value, as `--set` takes it; nothing where the controller has the number."""
    shown: tuple[Mapping[str, object], ...]
    """What each value changes of what the page knows of the stage."""


@dataclass(frozen=True)
class ArrayPlace:
    """An array in the memory of a world: its size [byte] depends on how many robots there are."""

    name: str
    fixed: int = 0
    per_robot: int = 0
    per_pair: int = 0
    is_kept: bool = False
    """The image of the world holds it; others are zeros when it begins."""
    same: str | None = None
    """It lies where the array of this name does."""


@dataclass(frozen=True)
class Driving:
    """How a visitor drives a robot: what is written to its record, and what a learner observes."""

    size: int
    """Of a record [byte]."""
    offset: int
    """Of the action in a record [byte]."""
    action: bytes
    """An action that takes over."""
    wheels: int
    """Offset of the speeds of the wheels in an action [byte]."""
    observed: Sequence[tuple[str, str, float]]
    """Name, unit and lower bound of each number of an observation."""


@dataclass(frozen=True)
class Program:
    """A swarm whose world runs in the page."""

    controller: str
    colour: str
    """As `#rrggbb`."""
    code: bytes
    """A module of WebAssembly that exports `swarm_run`, of `foraging.drawing.run_and_draw`."""
    image: bytes
    """The arrays that are kept, one after the other, as a world begins with them."""
    arrays: Sequence[ArrayPlace]
    """All arrays, in the order in which `swarm_run` takes them."""
    widths: Sequence[int]
    """Numbers that it takes after that of the robots: widths of arrays."""
    patches: Mapping[str, Sequence[Sequence[Patch]]]
    """What each value of a slider writes into the image, by the slider's name."""
    numbers: Sequence[str]
    """The sliders that change a number of its controller."""
    driving: Driving

    def about(self) -> dict[str, object]:
        """What the page must know of it."""
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
    command: tuple[str, str],
    programs: Sequence[Program],
    sliders: Sequence[Slider],
    columns: Sequence[str],
    every: int,
    replays: Sequence[Recording],
) -> str:
    """The HTML page; `columns` are what a program writes of a robot, `every` so many ticks.

    `command` is what makes the same episode in a terminal, up to its controllers and after them.
    `replays` are shown where there is no WebAssembly, one for each program.
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
