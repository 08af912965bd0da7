"""The style of every figure, and the boxplot in the papers' form."""

import pytest
from PIL import Image

from baselines.evaluation.box_plots import box_panels
from baselines.evaluation.plot_style import check_plot, save_figure
from swarm_forage_env.errors import ConfigError

COMMAND = "swarm-forage evaluate es1 nc ssgikf --episodes=5"
SAMPLES = {"nc": {"": [1.0, 2.0, 3.0, 4.0, 100.0]}, "ssgikf": {"": [5.0, 6.0, 7.0, 8.0, 9.0]}}


def draw(samples=SAMPLES):
    return box_panels({"es1": samples}, ("", "round trips"), COMMAND)


def test_boxes_are_quartiles_and_whiskers_reach_within_one_and_a_half_of_their_distance():
    axes = draw().axes[0]
    box = axes.patches[0].get_path().get_extents()
    assert (box.y0, box.y1) == (2.0, 4.0)
    heights = [line.get_ydata().tolist() for line in axes.lines]
    assert [3.0, 3.0] in heights, "the median"
    assert [4.0, 4.0] in heights, "the whisker stops at the last value within 1.5 IQR"
    assert [100.0] in heights, "the outlier"


def test_the_axis_starts_at_zero_and_names_what_it_shows():
    axes = draw().axes[0]
    assert axes.get_ylim()[0] == 0.0
    assert axes.get_ylabel() == "round trips"


def test_every_box_says_how_many_episodes_it_stands_for():
    labels = [label.get_text() for label in draw().axes[0].get_xticklabels()]
    assert labels == ["nc\nn = 5", "ssgikf\nn = 5"]


def test_boxes_that_only_the_legend_names_differ_in_hatch():
    groups = {"0.1": {"single": [1.0, 2.0], "double": [2.0, 3.0]}}
    figure = draw(groups)
    assert len({patch.get_hatch() for patch in figure.legends[0].get_patches()}) == 2
    assert [text.get_text() for text in figure.legends[0].texts] == ["single", "double"]


def test_many_boxes_stay_on_a_page_and_no_labels_overlap(texts_at_fault):
    figure = draw({f"ssgiff:\nbeta={number}": {"": [1.0, 2.0]} for number in range(18)})
    assert figure.get_figwidth() < 14.0
    assert texts_at_fault(figure) == []


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
def test_the_file_names_its_command_and_is_the_same_each_time(tmp_path, ending):
    files = [tmp_path / f"{number}{ending}" for number in (1, 2)]
    for file in files:
        save_figure(draw(), file, COMMAND)
    contents = [file.read_bytes() for file in files]
    assert contents[0] == contents[1]
    if ending == ".png":
        with Image.open(files[0]) as image:
            assert image.info["Description"] == COMMAND
            colours = image.convert("RGB").resize((60, 40)).getcolors(9999)
        assert len(colours) > 5, "not an empty page"
    else:
        assert COMMAND.encode() in contents[0]


def test_an_unknown_ending_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"must end in \.png, \.pdf, \.svg"):
        check_plot(tmp_path / "trips.jpeg")


def test_an_unwritable_file_is_refused(tmp_path):
    (tmp_path / "taken").write_text("")
    (tmp_path / "folder.png").mkdir()
    for file in (tmp_path / "taken" / "x.png", tmp_path / "folder.png"):
        with pytest.raises(ConfigError, match="cannot be written"):
            check_plot(file)


def test_the_check_leaves_no_file_and_keeps_an_old_one(tmp_path):
    new, old = tmp_path / "figures" / "new.png", tmp_path / "old.png"
    old.write_bytes(b"old")
    check_plot(new)
    check_plot(old)
    assert new.parent.is_dir()
    assert not new.exists()
    assert old.read_bytes() == b"old"
