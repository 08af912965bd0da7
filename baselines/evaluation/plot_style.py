"""Style of a series: the colour of its controller, and marks that distinguish it without colour."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from zlib import crc32

from baselines.controllers import OLD_NAMES

PALETTE = {
    "silver": "#BBBBBB",
    "vermilion": "#D55E00",
    "orange": "#E69F00",
    "blue": "#0072B2",
    "sky": "#56B4E9",
    "green": "#009E73",
    "pink": "#CC79A7",
    "wine": "#882255",
    "indigo": "#332288",
    "black": "#222222",
}
"""Ten colours that colour-blind readers can distinguish, visible on white in lines and fills.

Source: Okabe and Ito 2008 without its yellow; wine and indigo from P. Tol 2021, "muted".
"""

MARKERS, DASHES = "os^DvPXd<>p*", ("-", "--", "-.", ":")

HATCHES = (
    "", "///", "...", "xxx", "\\\\\\", "+++", "ooo", "---", "|||", "OO", "**", "//..",
)  # fmt: skip

CONTROLLERS = {
    "nc": ("silver", 0),
    "ssgikf": ("vermilion", 1),
    "dsgikf": ("orange", 2),
    "ssgiff": ("blue", 3),
    "dsgiff": ("sky", 4),
    "dsgiff-penalised": ("indigo", 5),
    "dsgiff-frequent": ("indigo", 6),
    "ssgikf-sceptical": ("vermilion", 10),
    "sikf": ("green", 8),
    "covariance": ("indigo", 5),
    "subsumption": ("green", 8),
    "boids-goal": ("sky", 6),
    "boids-static": ("vermilion", 2),
    "boids-adaptive": ("indigo", 5),
    "learned-weighting": ("pink", 7),
    "learned-motion": ("green", 8),
    "learned-both": ("wine", 9),
    "no-error": ("black", 6),
    "global": ("black", 5),
    "oracle-weighting": ("black", 11),
    "oracle-weighting-frequent": ("black", 4),
    "random": ("silver", 0),
    "sb3": ("sky", 3),
    "torchscript": ("orange", 4),
    "network": ("green", 5),
    "callable": ("pink", 2),
    "weighting": ("pink", 7),
    "motion": ("green", 8),
    "weighting-both": ("wine", 9),
    "motion-both": ("wine", 9),
}
"""Colour and number of the mark of named controllers, policy forms and bundled policies."""

INK, FAINT, GRID = "#222222", "#666666", "#dddddd"


@dataclass(frozen=True)
class SeriesStyle:
    """Style of one series: its colour, and marks that distinguish it without colour."""

    colour: str
    dashes: str  # of a line
    marker: str  # on a line
    hatch: str  # of a fill


def styles_of(
    names: Iterable[str], controllers: Mapping[str, str] | None = None
) -> dict[str, SeriesStyle]:
    """Return a style for each series of a figure, by the controller of that name.

    A controller has the same colour in every figure, whatever its parameters. It also has the same
    marker, dashes and hatch, unless another series of the figure has them; then the later series,
    or the one with parameters, takes the next ones. `controllers` maps the names of series to their
    controllers, if they differ.
    """
    controller_of = {name: (controllers or {}).get(name, name) for name in names}
    styles: dict[str, SeriesStyle] = {}
    used: set[int] = set()
    for name in sorted(controller_of, key=lambda each: ":" in controller_of[each]):
        colour, mark = _colour_and_mark(controller_of[name])
        while mark in used and len(used) < len(MARKERS):
            mark = (mark + 1) % len(MARKERS)
        used.add(mark)
        styles[name] = _style(colour, mark)
    return {name: styles[name] for name in controller_of}


def colour_of(controller: str) -> str:
    """Return the colour of a controller, whatever its parameters, in figures and in replays."""
    return PALETTE[_colour_and_mark(controller)[0]]


def nth_style(number: int) -> SeriesStyle:
    """Return the style of a series without controller, by number; 0 to 9 differ in colour."""
    colours = list(PALETTE)
    return _style(colours[(number + 1) % len(colours)], number % len(MARKERS))


def is_dark(colour: str) -> bool:
    """Return whether lines on a fill of this colour must be white (lightness: BT.601)."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return 0.299 * red + 0.587 * green + 0.114 * blue < 0.4 * 255


def _colour_and_mark(name: str) -> tuple[str, int]:
    """Return colour and mark of a controller; those of an unknown one are a hash of its name."""
    base = name.partition(":")[0]
    number = crc32(base.encode())
    known = OLD_NAMES.get(base, base)
    colour, mark = CONTROLLERS.get(known, (list(PALETTE)[number % len(PALETTE)], number // 16))
    return colour, (mark if base == name else crc32(name.encode())) % len(MARKERS)


def _style(colour: str, mark: int) -> SeriesStyle:
    return SeriesStyle(PALETTE[colour], DASHES[mark % len(DASHES)], MARKERS[mark], HATCHES[mark])
