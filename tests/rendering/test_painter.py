"""Pictures show the true places in the right colours, and the panel never covers the arena."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.layout import Layout, checked_size
from swarm_forage_env.rendering.painter import Painter, Show
from swarm_forage_env.rendering.viewer import frame_of
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.scene import LOST, TALKING, TO_THE_NEST
from swarm_forage_env.task import stage_of
from tests.rendering.scenes import AREAS, CORNERS, OBSTACLES, scene_of

STAGE = stage_of(find_scenario("es1"), "ssgikf")


def near(colour, within=6):
    """A colour, but for what smoothing does to it."""
    return pytest.approx(colour, abs=within)


def scene(places, activity=LOST, **changes):
    """Robots at these places, looking along y, all doing the same, without messages."""
    pose = [(x, y, np.pi / 2) for x, y in places]
    return scene_of(pose, activity=np.full(len(places), activity, np.int8), **changes)


def painted(*scenes, stage=STAGE, width=512, show=None, beliefs=False):
    """The frame of the last scene, and a function from places to colours."""
    layout = Layout(stage, width, beliefs=beliefs)
    painter = Painter(stage, layout)
    for each in scenes:
        painter.take(each)
        frame = frame_of(painter.paint(each, show or Show()))

    def at(x, y):
        column, row = np.round(layout.in_picture(np.array([x, y])) - 0.5).astype(int)
        return tuple(frame[row, column].tolist())

    return frame, at


@pytest.mark.parametrize("name", ["es1", "es3", "ants2008"])
def test_areas_and_floor_lie_where_they_are(name):
    stage = stage_of(find_scenario(name), "nc")
    _, at = painted(scene([(0.0, 0.0)]), stage=stage, width=720)
    for (x, y), colour in zip(stage.areas, palette.AREA, strict=True):
        inside = palette.mixed(colour, palette.FLOOR, 0.28)
        assert at(x, y - 0.6 * stage.area_radius) == near(inside)
        assert at(x, y - 1.6 * stage.area_radius) == near(palette.FLOOR)
    assert at(0.49 * stage.length, 0.49 * stage.width) == near(palette.FLOOR)


def test_several_areas_lie_where_they_are_and_one_moves():
    stage = stage_of(find_scenario("es1", {"task.areas": AREAS}), "nc")
    assert stage.names == ("nest", "prey", "nest x2")
    nest, prey = (palette.mixed(colour, palette.FLOOR, 0.28) for colour in palette.AREA)
    early, late = scene([(0.0, 0.0)], time=49.0), scene([(0.0, 0.0)])
    for scenes, up, down in (([early], prey, palette.FLOOR), ([early, late], palette.FLOOR, prey)):
        _, at = painted(*scenes, stage=stage, width=720)
        for place, colour in (((0.7, 0.24), up), ((0.7, -0.36), down)):
            assert at(*place) == near(colour)
        assert at(-0.7, -0.06) == near(nest)
        assert at(-0.5, 0.34) == near(nest)


def test_the_error_of_a_belief_is_told_to_the_nearest_area_of_its_kind():
    areas = [{"kind": kind, "centre": [x, y]} for kind, x in (("nest", -0.7), ("prey", 0.7))
             for y in (-0.3, 0.3)]  # fmt: skip
    stage = stage_of(find_scenario("es1", {"task.areas": areas}), "nc")
    assert stage.nearest_area(0, np.array([-0.2, 0.1]), 0.0).tolist() == [-0.7, 0.3]
    assert stage.nearest_area(1, np.array([-0.2, -0.1]), 0.0).tolist() == [0.7, -0.3]


def test_of_a_robot_that_believes_nothing_no_area_is_told():
    stage = replace(STAGE, believes=False)
    panel = Painter(stage, Layout(stage, 512, beliefs=True))._panel
    assert panel._words_on(scene([(0.0, 0.0)]), 0) == "Robot 0: lost"
    assert Layout(stage, 512, beliefs=True).height < Layout(STAGE, 512, beliefs=True).height


def test_obstacles_and_the_outer_wall_lie_where_they_are():
    scenario = find_scenario("es1", {"obstacles": OBSTACLES, "arena.corners": CORNERS})
    _, at = painted(scene([(0.0, 0.0)]), stage=stage_of(scenario, "nc"), width=720)
    for place in ((0.3, 0.3), (-0.3, 0.4), (-0.3, 0.49), (0.0, -0.4), (0.83, -0.58)):
        assert at(*place) == near(palette.WALL)
    for place in ((0.35, 0.3), (-0.3, 0.52), (0.2, -0.4), (0.7, -0.5)):
        assert at(*place) == near(palette.FLOOR)


@pytest.mark.parametrize(
    ("name", "width"), [("es1", 400), ("es1", 512), ("es3", 512), ("es3", 900)]
)
def test_a_robot_is_drawn_where_it_is_in_the_colour_of_what_it_does(name, width):
    stage = stage_of(find_scenario(name), "nc")
    x, y = 0.31 * stage.length, 0.23 * stage.width
    for activity in (TO_THE_NEST, LOST, TALKING):
        _, at = painted(scene([(x, y)], activity), stage=stage, width=width)
        behind = 0.5 * Layout(stage, width).robot_radius / Layout(stage, width).scale
        assert at(x, y - behind) == near(palette.ROBOT[activity], 40)


def test_a_robot_is_to_scale_and_its_wedge_points_ahead():
    frame, at = painted(scene([(0.3, 0.2)]), show=Show(trails=False))
    assert at(0.3, 0.2 + 0.015) == near(palette.WHITE)
    assert at(0.3, 0.2 - 0.015) == near(palette.BLACK)
    layout = Layout(STAGE, 512)
    x, y = np.round(layout.in_picture(np.array([0.3, 0.2]))).astype(int)
    dark = np.flatnonzero(frame[y, x - 30 : x + 30].max(axis=1) < 128)
    assert np.ptp(dark) + 1 == pytest.approx(2 * STAGE.robot_radius * layout.scale, abs=2.5)


@pytest.mark.parametrize("name", ["es1", "es3"])
@pytest.mark.parametrize("width", [400, 512, 1280])
def test_the_panel_stays_outside_the_arena(name, width):
    stage = stage_of(find_scenario(name), "a-controller:with=many,numbers=in,its=long,name=yes")
    words = {"time": 700.0, "on_path": 1.0}
    here = [scene([(0.0, 0.0)], **change) for change in ({}, words)]
    here[1].round_trips[:] = 12345
    frames = [painted(each, stage=stage, width=width, beliefs=True)[0] for each in here]
    layout = Layout(stage, width, beliefs=True)
    (left, top), (length, height) = layout.corner, layout.arena
    assert frames[0].shape == (layout.height, width, 3)
    differ = (frames[0] != frames[1]).any(axis=2)
    assert differ.any()
    assert not differ[top - 2 : top + height + 2, left - 2 : left + length + 2].any()
    for frame in frames:
        edges = np.concatenate([frame[:, :3], frame[:, -3:]], axis=1)
        assert (edges == 255).all()
        assert (frame[-3:] == 255).all()


def test_a_name_leaves_its_place_for_a_robot_and_only_then():
    alone, _ = painted(scene([(0.0, 0.3)]), width=720)
    near_it, _ = painted(scene([(STAGE.areas[0][0], 0.0)]), width=720)
    layout = Layout(STAGE, 720)
    x, y = np.round(layout.in_picture(STAGE.areas[0])).astype(int)
    radius = round(STAGE.area_radius * layout.scale)

    def dark(frame, down):
        return (frame[y + down - 8 : y + down + 8, x - 15 : x + 15].max(axis=2) < 90).sum()

    assert dark(alone, 0) > 20, "the name stands in the nest"
    assert dark(alone, -radius - 14) == 0
    assert dark(near_it, -radius - 14) > 20, "a robot is there: the name stands above"


def test_trails_lead_back_to_where_a_robot_came_from_in_this_episode():
    way = [scene([(0.1 + 0.01 * k, 0.3)], time=60.0 + k) for k in range(20)]
    _, at = painted(*way)
    _, without = painted(*way, show=Show(trails=False))
    _, begun = painted(*way, scene([(-0.2, -0.3)], time=0.0))
    assert without(0.2, 0.3) == begun(0.2, 0.3) == near(palette.FLOOR)
    old, young = at(0.13, 0.3), at(0.22, 0.3)
    assert max(young) < max(old) < min(palette.FLOOR)


def test_a_message_is_an_arc_to_the_left_of_its_way_for_half_a_second():
    picture = scene([(0.2, 0.3), (0.34, 0.3)], messages=np.array([[0, 1]], np.int32))
    frame, _ = painted(picture)
    hidden, _ = painted(picture, show=Show(messages=False))
    rows, columns = np.nonzero((frame != hidden).any(axis=2))
    places = np.stack([columns, rows], axis=1) - Layout(STAGE, 512).in_picture(
        np.array([0.27, 0.3])
    )
    assert len(places) > 20
    assert places[:, 1].min() < -5
    assert places[:, 1].max() <= 2
    assert abs(places[:, 0].mean()) < 2
    silent = replace(picture, messages=np.zeros((0, 2), np.int32))
    never, _ = painted(silent)
    for later, seen in ((0.3, True), (0.6, False)):
        frame, _ = painted(picture, replace(silent, time=60.0 + later), show=Show(trails=False))
        assert (frame != never).any() == seen


def test_beliefs_of_the_selected_robot_alone_are_drawn():
    believed = np.zeros((2, 2, 2))
    believed[0, 1], believed[1, 1] = (0.4, 0.35), (-0.3, -0.4)
    known = np.array([[False, True], [False, True]])
    p = np.array([[0.0, 0.5], [0.0, 0.5]], np.float32)
    here = scene([(0.0, 0.0), (0.1, -0.2)], believed=believed, known=known, p=p)
    ring = 0.1 + 0.1 * 0.5
    _, at = painted(here, show=Show(selected=0), beliefs=True)
    assert at(0.4, 0.35) == near(palette.INK, 30)
    rim = [at(0.4 - ring + step, 0.35)[2] for step in (0.0, 0.004)]
    assert min(rim) < 180 < palette.FLOOR[2]
    assert at(-0.3, -0.4) == near(palette.FLOOR)
    assert at(-0.3 - ring, -0.4) == near(palette.FLOOR)
    _, hidden = painted(here, show=Show(selected=0, beliefs=False), beliefs=True)
    assert hidden(0.4, 0.35) == near(palette.FLOOR)


def test_painting_twice_makes_the_same_picture():
    here = scene([(0.2, 0.3), (0.3, 0.3)], messages=np.array([[0, 1]], np.int32))
    assert_array_equal(painted(here)[0], painted(here, here)[0])


@pytest.mark.parametrize("size", [0, 399, 3841])
def test_a_size_that_words_do_not_fit_is_refused(size):
    with pytest.raises(ConfigError, match=rf"size={size}: must be 400 to 3840 \[px\]"):
        checked_size(size)


def test_a_faulty_robot_is_crossed_in_red_and_the_legend_says_so():
    faulty_stage = stage_of(find_scenario("es1", {"faults.liar.share": 0.2}), "ssgikf")
    assert faulty_stage.has_faults
    assert not STAGE.has_faults
    two = scene([(-0.3, 0.0), (0.3, 0.0)], TO_THE_NEST)
    marked = replace(two, faulty=np.array([True, False]))
    frame, at = painted(marked, stage=faulty_stage, width=1200)
    assert at(-0.3, 0.0) == near(palette.FAULTY, 40)
    assert at(0.3, 0.0) != near(palette.FAULTY, 40)
    plain, _ = painted(two, width=1200)
    legend = np.argwhere((frame != plain).any(axis=2))
    assert legend[:, 0].max() > frame.shape[0] - 60
