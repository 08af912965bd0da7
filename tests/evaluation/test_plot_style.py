"""The colour and marks of a controller: the same in every figure, and told apart by everybody."""

from itertools import combinations, pairwise

import matplotlib as mpl
import numpy as np
import pytest

from baselines.evaluation.plot_style import PALETTE, colour_of, nth_style, style_of, styles_of

README = (
    "nc", "ssgikf", "dsgikf", "ssgiff:beta=0.001", "ssgiff", "dsgiff", "dsgiff-frequent:beta=0.003",
    "learned-weighting", "learned-motion", "learned-both",
)  # fmt: skip
"""The controllers of the first figure of the README."""

SIGHT = {
    "usual": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
"""From linear RGB to what is seen (Machado et al. 2009, severity 1)."""

XYZ = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]


def lab(colour, sight):
    """A colour in CIELAB, as seen."""
    rgb = np.array(mpl.colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(SIGHT[sight]) @ linear, 0.0, 1.0)
    xyz = np.array(XYZ) @ seen / (0.95047, 1.0, 1.08883)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("sight", SIGHT)
def test_colour_blind_readers_tell_the_ten_colours_apart(sight):
    seen = [lab(colour, sight) for colour in PALETTE.values()]
    assert len(seen) == 10
    assert min(np.linalg.norm(one - other) for one, other in combinations(seen, 2)) > 14.0


def test_a_controller_has_one_colour_whatever_its_parameters_and_company():
    alone = style_of("ssgiff")
    among = styles_of(["learned-both", "nc", "ssgiff:beta=0.01", "ssgiff"])
    assert among["ssgiff"] == alone
    assert among["ssgiff:beta=0.01"].colour == alone.colour
    assert style_of("somebody-elses").colour == style_of("somebody-elses:x=1").colour
    assert colour_of("ssgiff:beta=0.01") == alone.colour
    assert colour_of("dsgiff-brisk") == colour_of("dsgiff-frequent"), "its old name"


def test_ten_controllers_are_told_apart_without_colour():
    styles = styles_of(README).values()
    assert len({style.marker for style in styles}) == len({style.hatch for style in styles}) == 10


def test_the_variants_of_one_controller_differ_in_marker_and_hatch():
    styles = styles_of([f"ssgiff:beta={number}" for number in range(12)]).values()
    assert len({style.colour for style in styles}) == 1
    assert len({style.marker for style in styles}) == len({style.hatch for style in styles}) == 12


def test_what_is_no_controller_is_numbered():
    styles = [nth_style(number) for number in range(10)]
    assert len({style.colour for style in styles}) == 10
    assert all(one.marker != other.marker for one, other in pairwise(styles))
