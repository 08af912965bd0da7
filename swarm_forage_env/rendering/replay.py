"""Replay: an episode as one HTML file that plays in a browser, without server or network.

The page is assembled from the files in `html/`; `recording.py` packs the values.
"""

import base64
import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from string import Template

from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.layout import P_RING
from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.trails import JUST_NOW, TRAIL
from swarm_forage_env.scene import EXPLORING, STATES, WITHIN, Outline, Scene, Stage

BUDGET = 6_000_000
"""Target for the size of a file [byte], which determines the time between frames."""

BYTES_PER_ROBOT = 12
"""Approximate size of one robot in one frame [byte]; smaller in es1 and es3."""

SCRIPTS = ("load", "view", "arena", "labels", "goals", "curves", "panel", "drive", "live", "player")
"""Scripts of the page, in loading order."""


STAGE_FIELDS = (
    "scenario", "length", "width", "kinds", "names", "moves", "tick", "states", "believes",
    "headings",
)  # fmt: skip
"""Fields of a stage that have the same name in the page."""

COLOURS = (
    "message", "selected", "faulty", "goal", "right", "wrong", "estimate", "lidar", "floor", "wall",
    "ink", "faint",
)  # fmt: skip
"""Colours of the palette that have the same name, in lower case, in the page."""


@dataclass(frozen=True)
class Opening:
    """Initial state of a page, and the second swarm that it shows."""

    start: float = 0.0
    """Time at which playback starts [s]; earlier scenes only provide trails."""
    speed: float = 10.0
    """Playback speed, as a multiple of real time."""
    select: int | None = None
    """Index of the selected robot."""
    second_controller: str | None = None
    """Controller of a second swarm in the same world, shown next to the first."""
    colours: tuple[str, ...] = ("#0072b2", "#e69f00")
    """Colour of the curves and the label of each controller, as `#rrggbb`."""


class Replay:
    """Writer of the scenes of one episode, or of two in the same world, as one HTML file.

    `command` is the command line that produced the episode. Every scene becomes a frame if the file
    stays below `BUDGET`; otherwise every second scene, every fourth, and so on. `n_scenes` is the
    number of scenes per swarm; None: those of a whole episode.
    """

    def __init__(
        self,
        stage: Stage,
        seed: int,
        command: str,
        n_scenes: int | None = None,
        opening: Opening | None = None,
    ) -> None:
        self._stage, self._seed, self._command = stage, seed, command
        self._opening = opening or Opening()
        second = self._opening.second_controller
        self._controllers = [stage.controller] if second is None else [stage.controller, second]
        n_scenes = n_scenes or round(stage.duration / stage.tick) + 1
        max_frames = BUDGET // (BYTES_PER_ROBOT * stage.n_robots * len(self._controllers))
        every = 1
        while n_scenes > every * max(2, max_frames):
            every *= 2
        self._recordings = [Recording(every) for _ in self._controllers]

    def add(self, scene: Scene, swarm: int = 0) -> None:
        """Add the next scene of a swarm. ConfigError if it is not later than the last."""
        self._recordings[swarm].add(scene)

    def write(self, file: Path) -> None:
        """Write the page to a file, atomically; ConfigError without a scene, or if that fails."""
        page = self.page()
        try:
            write_atomically(file, page.encode())
        except OSError as error:
            raise ConfigError(f"{file}: cannot be written ({error.strerror})") from None

    def page(self) -> str:
        """Return the HTML page; ConfigError without a scene, or if two swarms differ in times."""
        packs = [recording.pack() for recording in self._recordings]
        if len({(about["frames"], about["every"]) for about, _ in packs}) > 1:
            raise ConfigError("scenes of two swarms: must have the same times; add both at each")
        colours = self._opening.colours[: len(packs)]
        swarms = [
            {"controller": name, "colour": colour} | about
            for name, colour, (about, _) in zip(self._controllers, colours, packs, strict=True)
        ]
        return page_of(
            f"{self._stage.scenario} · {' and '.join(self._controllers)} · seed {self._seed}",
            about_of(self._stage, self._command, self._opening) | {"seed": self._seed},
            swarms,
            [packed for _, packed in packs],
        )


def page_of(
    title: str,
    about: Mapping[str, object],
    swarms: Sequence[Mapping[str, object]],
    packed: Sequence[bytes],
    also: str = "",
    others: str = "",
) -> str:
    """Return the HTML page of some swarms, with the packed values of each.

    `also` holds additional permissions of its scripts; `others` are elements that they read.
    """
    first, *rest = swarms
    content = json.dumps({**about, **first, "beside": rest})
    return Template(part("replay.html")).substitute(
        title=html.escape(title),
        also=also,
        style=part("replay.css"),
        about=content.replace("<", "\\u003c"),
        recordings="\n".join(
            [*(element_of(f"recording-{k}", each) for k, each in enumerate(packed)), others]
        ),
        script="\n".join(part(f"{name}.js") for name in SCRIPTS),
    )


def about_of(stage: Stage, command: str, opening: Opening) -> dict[str, object]:
    """Return the data of a stage that a page needs, and its initial state."""
    return {
        **{name: getattr(stage, name) for name in STAGE_FIELDS},
        **{name: getattr(opening, name) for name in ("start", "speed", "select")},
        "command": command,
        "areas": stage.areas.tolist(),
        "areaRadius": stage.area_radius,
        "startRadius": stage.start_radius,
        "corners": stage.corners.tolist(),
        "obstacles": obstacles_shown(stage.obstacles),
        "robotRadius": stage.robot_radius,
        "robots": stage.n_robots,
        "goals": None if stage.goals is None else asdict(stage.goals) | {"within": WITHIN},
        "trail": TRAIL,
        "justNow": JUST_NOW,
        "ring": P_RING,
        "colours": _colours(),
    }


def obstacles_shown(obstacles: Sequence[Outline]) -> list[dict[str, object]]:
    """Return obstacles in the format of the page."""
    return [
        {"points": each.points.tolist(), "radius": each.radius, "closed": each.is_closed}
        for each in obstacles
    ]


def _colours() -> dict[str, str | list[str]]:
    codes = range(len(STATES))
    return {
        "doing": [_css(palette.ROBOT[code]) for code in codes],
        "noses": [_css(palette.INK if code == EXPLORING else palette.WHITE) for code in codes],
        "trails": [_css(palette.trail_colour(code)) for code in codes],
        "areas": [_css(colour) for colour in palette.AREA],
        **{name: _css(getattr(palette, name.upper())) for name in COLOURS},
    }


def _css(colour: palette.Colour) -> str:
    """Format a colour for the page.

    >>> _css((0, 114, 178))
    '#0072b2'
    """
    return "#{:02x}{:02x}{:02x}".format(*colour)


def element_of(name: str, packed: bytes) -> str:
    """Return the element of a page that holds packed values, such as those of a swarm."""
    text = base64.b64encode(packed).decode("ascii")
    return f'<script type="text/plain" id="{name}">{text}</script>'


def part(name: str) -> str:
    """Return the content of a source file of the pages."""
    return (resources.files(__package__) / "html" / name).read_text(encoding="utf-8")
