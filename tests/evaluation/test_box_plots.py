"""Box plots in the papers' form, and the files of a figure."""

import json
from itertools import combinations, pairwise

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from baselines.evaluation.box_plots import box_panels
from baselines.evaluation.figure_page import Caption, draw_caption, page_style, save_figure
from baselines.evaluation.line_plots import Means, curve_panels, mean_panels
from baselines.evaluation.plot_style import PALETTE, colour_of, nth_style, styles_of

COMMAND = "swarm-forage evaluate es1 nc ssgikf --episodes=5"
CAPTION = Caption("Round trips.", "n = 5 episodes each", COMMAND, ("0123abcd",))
SAMPLES = {"nc": {"": [1.0, 2.0, 3.0, 4.0, 100.0]}, "ssgikf": {"": [5.0, 6.0, 7.0, 8.0, 9.0]}}


def draw(samples=SAMPLES):
    return box_panels({"es1": samples}, ("", "round trips"), CAPTION)


def labels(axis):
    return [label.get_text() for label in axis.get_ticklabels()]


def test_boxes_are_quartiles_with_whiskers_the_first_on_top_and_start_at_zero():
    axes = draw().axes[0]
    box = axes.patches[0].get_path().get_extents()
    assert (box.x0, box.x1) == (2.0, 4.0)
    places = [line.get_xdata().tolist() for line in axes.lines]
    for place in ([3.0, 3.0], [4.0, 4.0], [100.0]):  # median, last value within 1.5 IQR, outlier
        assert place in places
    assert labels(axes.yaxis) == ["nc", "ssgikf"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]
    assert axes.get_xlim()[0] == 0.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("round trips", "")


def test_negative_values_are_seen():
    assert draw({"nc": {"": [-3.0, 1.0]}}).axes[0].get_xlim()[0] < -3.0
    means = {"es1": {"nc": Means(np.arange(2.0), *-np.ones((3, 2)))}}
    for panels in (curve_panels, mean_panels):
        assert panels(means, ("x", "y"), CAPTION).axes[0].get_ylim()[0] < -1.0


def test_boxes_of_numbers_stand_and_decades_are_powers_of_ten():
    axes = draw({"1e-05": {"": [1.0, 2.0]}, "0.003": {"": [1.0]}, "1": {"": [2.0]}}).axes[0]
    assert labels(axes.xaxis) == [f"$10^{{{power}}}$" for power in range(-5, 1)]
    assert axes.get_xticks().tolist() == [-5, -4, -3, -2, -1, 0]
    assert axes.get_ylabel() == "round trips"
    axes = draw({"2": {"": [1.0, 2.0]}, "50": {"": [1.0]}}).axes[0]
    assert labels(axes.xaxis) == ["2", "50"]


def test_n_is_told_once_and_at_boxes_of_fewer_episodes():
    figure = draw(SAMPLES | {"dsgiff": {"": [1.0, 2.0]}, "sikf": {"": []}})
    assert figure.get_supxlabel() == "n = 5 episodes each"
    assert [text.get_text() for text in figure.axes[0].texts] == ["n = 2", "none"]


def test_boxes_that_only_the_legend_names_differ_in_hatch():
    (legend,) = draw({"0.1": {"single": [1.0, 2.0], "double": [2.0, 3.0]}}).legends
    assert len({patch.get_hatch() for patch in legend.get_patches()}) == 2
    assert [text.get_text() for text in legend.texts] == ["single", "double"]


@pytest.mark.parametrize("style", ["screen", "paper"])
def test_many_boxes_stay_on_a_page_and_no_labels_overlap(texts_at_fault, style):
    name = "learned-both:weighting.policy=weighting,motion.policy=motion"
    samples = {f"{name},pause={number}": {"": [1.0, 2.0]} for number in range(18)}
    with page_style(style):
        figure = draw(samples)
        assert texts_at_fault(figure) == []
    assert figure.get_figwidth() == {"screen": 8.0, "paper": 3.35}[style]


@pytest.mark.parametrize("style", ["screen", "paper"])
def test_long_settings_and_files_of_policies_stay_on_the_page(texts_at_fault, style):
    name = "network:runs/sweep-of-learning-rates/lr-0.0003-seed-12-batch-4096/best.safetensors"
    setup = "es1, radio.max_range=0.2, task.duration=300, task.n_robots=12, kinematic"
    line = Means(*np.ones((4, 3)))
    with page_style(style):
        figures = [
            box_panels({setup: {name: {"": [1.0, 2.0]}}, "es2": SAMPLES}, ("", "trips"), CAPTION),
            curve_panels({setup: {name: line, "nc": line}}, ("time [s]", "trips"), CAPTION),
        ]
        assert [texts_at_fault(each) for each in figures] == [[], []]


def test_the_usual_style_comes_back():
    with pytest.raises(ValueError, match="any"), page_style("paper"):
        raise ValueError("any")
    assert draw().get_figwidth() == 8.0


def test_command_and_code_are_drawn_only_if_asked_for():
    figure, shown = draw(), []
    for draw_more in (lambda _: None, draw_caption):
        draw_more(figure)
        figure.draw_without_rendering()
        texts = [*(text.get_text() for text in figure.texts), figure.get_supxlabel()]
        shown.append(" ".join(" ".join(texts).split()))
    assert "swarm-forage" not in shown[0]
    assert "0123abcd" not in shown[0]
    assert shown[1].endswith(f"n = 5 episodes each. Code 0123abcd. {COMMAND}")


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
def test_the_file_holds_its_caption_and_is_the_same_each_time(tmp_path, ending):
    files = [tmp_path / f"{number}{ending}" for number in (1, 2)]
    for file in files:
        save_figure(draw(), file)
    contents = [file.read_bytes() for file in files]
    assert contents[0] == contents[1]
    if ending == ".png":
        with Image.open(files[0]) as image:
            assert image.info["Description"] == str(CAPTION)
            colours = image.convert("RGB").resize((60, 40)).getcolors(9999)
        assert len(colours) > 5, "not an empty page"
    else:
        assert COMMAND.encode() in contents[0]
        assert b"0123abcd" in contents[0]


def test_a_file_beside_the_figure_holds_the_parts_of_its_caption(tmp_path):
    save_figure(draw(), tmp_path / "trips.png", "Trips")
    assert json.loads((tmp_path / "trips.png.json").read_text()) == {
        "title": "Trips",
        "text": "Round trips.",
        "note": "n = 5 episodes each",
        "command": COMMAND,
        "code": ["0123abcd"],
    }


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
    alone = styles_of(["ssgiff"])["ssgiff"]
    among = styles_of(["learned-both", "nc", "ssgiff:beta=0.01", "ssgiff"])
    assert among["ssgiff"] == alone
    assert among["ssgiff:beta=0.01"].colour == alone.colour
    assert colour_of("somebody-elses") == colour_of("somebody-elses:x=1")
    assert colour_of("ssgiff:beta=0.01") == alone.colour
    assert colour_of("sb3:model.zip") not in {colour_of("nc"), colour_of("ssgikf")}
    assert colour_of("dsgiff-brisk") == colour_of("dsgiff-frequent"), "its old name"


@pytest.mark.parametrize(
    ("names", "colours"), [(README, 9), ([f"ssgiff:beta={number}" for number in range(12)], 1)]
)
def test_controllers_and_variants_of_one_are_told_apart_without_colour(names, colours):
    styles = styles_of(names).values()
    assert len({style.colour for style in styles}) == colours
    for mark in ("marker", "hatch"):
        assert len({getattr(style, mark) for style in styles}) == len(names)


def test_what_is_no_controller_is_numbered():
    styles = [nth_style(number) for number in range(10)]
    assert len({style.colour for style in styles}) == 10
    assert all(one.marker != other.marker for one, other in pairwise(styles))
