"""A replay: an episode as one HTML file that plays in a browser, without server or network.

The page is put together from the files in `page/`; `recording.py` packs the numbers.
"""

import base64
import html
import json
from dataclasses import asdict
from importlib import resources
from pathlib import Path
from string import Template

from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.layout import P_RING
from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.trails import JUST_NOW, TRAIL
from swarm_forage_env.scene import EXPLORING, STATES, WITHIN, Scene, Stage

BUDGET = 6_000_000
"""Size that a file should not exceed [byte]; the time between frames follows."""

BYTES_PER_ROBOT = 12
"""A robot in one frame takes about this much of the file [byte]; es1 and es3 take less."""

SCRIPTS = ("load.js", "view.js", "arena.js", "goals.js", "curves.js", "panel.js", "player.js")
"""The page's scripts, in the order they are read."""


class Replay:
    """Takes the scenes of one episode and writes them to one HTML file."""

    def __init__(self, stage: Stage, seed: int, command: str, budget: int = BUDGET) -> None:
        """Nothing recorded yet; `command` is what the user typed to make this episode.

        Every scene becomes a frame as long as the file stays below the budget [byte]; beyond,
        every second, every fourth and so on.
        """
        self._stage, self._seed, self._command = stage, seed, command
        self._recording = Recording(max(2, budget // (BYTES_PER_ROBOT * stage.n_robots)))

    def add(self, scene: Scene) -> None:
        """Take the next scene. ConfigError if it is not later than the last."""
        self._recording.add(scene)

    def write(self, file: Path) -> None:
        """Write the page to a file, which appears whole or not at all.

        ConfigError where no scene was added or the file cannot be written.
        """
        page = self.page()
        try:
            write_atomically(file, page.encode())
        except OSError as error:
            raise ConfigError(f"{file}: cannot be written ({error.strerror})") from None

    def page(self) -> str:
        """The HTML page. ConfigError where no scene was added."""
        columns, packed = self._recording.pack()
        about = json.dumps(self._about() | columns).replace("<", "\\u003c")
        stage = self._stage
        return Template(_part("replay.html")).substitute(
            title=html.escape(f"{stage.scenario} · {stage.controller} · seed {self._seed}"),
            style=_part("replay.css"),
            about=about,
            recording=base64.b64encode(packed).decode("ascii"),
            script="\n".join(_part(name) for name in SCRIPTS),
        )

    def _about(self) -> dict[str, object]:
        stage = self._stage
        return {
            "scenario": stage.scenario,
            "controller": stage.controller,
            "seed": self._seed,
            "command": self._command,
            "length": stage.length,
            "width": stage.width,
            "areas": stage.areas.tolist(),
            "kinds": stage.kinds,
            "names": stage.names,
            "moves": stage.moves,
            "areaRadius": stage.area_radius,
            "startRadius": stage.start_radius,
            "corners": stage.corners.tolist(),
            "obstacles": [
                {"points": each.points.tolist(), "radius": each.radius, "closed": each.is_closed}
                for each in stage.obstacles
            ],
            "robotRadius": stage.robot_radius,
            "robots": stage.n_robots,
            "tick": stage.tick,
            "states": stage.states,
            "headings": stage.headings,
            "goals": None if stage.goals is None else asdict(stage.goals) | {"within": WITHIN},
            "trail": TRAIL,
            "justNow": JUST_NOW,
            "ring": P_RING,
            "colours": _colours(),
        }


def _colours() -> dict[str, object]:
    codes = range(len(STATES))
    return {
        "doing": [_css(palette.DOING[code]) for code in codes],
        "noses": [_css(palette.INK if code == EXPLORING else palette.WHITE) for code in codes],
        "trails": [_css(palette.trail_colour(code)) for code in codes],
        "areas": [_css(colour) for colour in palette.AREA],
        "message": _css(palette.MESSAGE),
        "selected": _css(palette.SELECTED),
        "faulty": _css(palette.FAULTY),
        "goal": _css(palette.GOAL),
        "right": _css(palette.RIGHT),
        "wrong": _css(palette.WRONG),
        "estimate": _css(palette.ESTIMATE),
        "lidar": _css(palette.LIDAR),
        "floor": _css(palette.FLOOR),
        "wall": _css(palette.WALL),
        "ink": _css(palette.INK),
        "faint": _css(palette.FAINT),
    }


def _css(colour: palette.Colour) -> str:
    """As the page writes it.

    >>> _css((0, 114, 178))
    '#0072b2'
    """
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _part(name: str) -> str:
    return (resources.files(__package__) / "html" / name).read_text(encoding="utf-8")
