"""A replay is one file that stands alone, tells what it shows, and appears whole or not at all."""

import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.recording import Recording
from swarm_forage_env.rendering.replay import BUDGET, BYTES_PER_ROBOT, Replay
from tests.rendering.replay.pages import parts, unpacked

COMMAND = "swarm-forage watch es1 ssgikf --seed=1"
ES1_LIMIT = 5_000_000


@pytest.fixture
def replay(stage, made_up):
    found = Replay(replace(stage, n_robots=3), 1, COMMAND)
    found.add(made_up(0))
    return found


class References(HTMLParser):
    """Collects whatever a browser might fetch."""

    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attrs):
        fetched = {"src", "href", "srcset", "action", "data", "poster", "background"}
        self.found += [value for name, value in attrs if name in fetched]


def test_a_page_refers_to_nothing_outside_itself(replay):
    page, references = replay.page(), References()
    references.feed(page)
    assert references.found == ["data:,"]
    code = re.sub(r'<script type="text/plain".*?</script>', "", page, flags=re.DOTALL)
    assert not re.findall(r"https?:|@import|url\(|import\(|fetch\(|XMLHttp|WebSocket", code)
    assert "default-src 'none'" in page


def test_a_page_names_all_it_shows_and_names_cannot_break_out_of_their_place(stage, made_up):
    name = '</script><b>&amp; $about "x"'
    replay = Replay(replace(stage, n_robots=3, controller=name), 1, name)
    replay.add(made_up(0))
    page = replay.page()
    about, _ = parts(page)
    assert (about["controller"], about["command"]) == (name, name)
    for tag in ("title", "h1"):
        text = re.search(f"<{tag}>(.*?)</{tag}>", page)[1]
        assert html.unescape(text) == f"es1 · {name} · seed 1"
    assert page.count("</script>") == 3
    assert "<b>" not in page


def test_an_es1_episode_takes_less_than_its_limit(stage, scenes):
    replay = Replay(stage, 1, COMMAND)
    for scene in scenes:
        replay.add(scene)
    page = replay.page()
    about, packed = parts(page)
    assert about["every"] == 1
    assert len(packed) * 4 / 3 < BYTES_PER_ROBOT * len(scenes) * stage.n_robots
    ticks = round(stage.duration / stage.tick)
    rest = len(page.encode()) - len(packed) * 4 // 3
    assert BYTES_PER_ROBOT * ticks * stage.n_robots + rest < ES1_LIMIT
    assert BYTES_PER_ROBOT * ticks * stage.n_robots < BUDGET


def test_a_smaller_budget_keeps_fewer_frames(stage, scenes, monkeypatch):
    sizes = []
    for budget in (BUDGET, 40_000):
        monkeypatch.setattr("swarm_forage_env.rendering.replay.BUDGET", budget)
        replay = Replay(stage, 1, COMMAND, len(scenes))
        for scene in scenes:
            replay.add(scene)
        about, packed = parts(replay.page())
        times = unpacked(about, packed)[0]
        assert times[1] - times[0] == pytest.approx(about["every"] * stage.tick, abs=1e-4)
        sizes.append((about["every"], len(packed)))
    assert sizes[0][0] == 1
    assert sizes[1][0] == 8
    assert sizes[1][1] * 4 / 3 < 40_000


@pytest.mark.parametrize("name", ["file/x.html", "folder"])
def test_a_file_that_cannot_be_written_is_refused_in_one_line(replay, tmp_path, name):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    with pytest.raises(ConfigError, match=r"cannot be written \(.+\)$") as refused:
        replay.write(tmp_path / name)
    assert "\n" not in str(refused.value)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "folder"]


def recorded(scenes, every=1):
    recording = Recording(every)
    for scene in scenes:
        recording.add(scene)
    return recording


def stacked(scenes, what):
    """Robots x frames."""
    return np.stack([what(scene) for scene in scenes], axis=1)


def apart(a, b):
    return np.abs(np.angle(np.exp(1j * (a - b))))


def check_columns(columns, scenes):
    for axis, name in enumerate("xy"):
        true = stacked(scenes, lambda s, axis=axis: s.pose[:, axis])
        assert_allclose(columns[name], true, atol=0.00051)
    assert apart(columns["heading"], stacked(scenes, lambda s: s.pose[:, 2])).max() < 0.0031
    assert_array_equal(columns["doing"], stacked(scenes, lambda s: s.activity))
    assert_array_equal(columns["trips"], stacked(scenes, lambda s: s.round_trips))
    for area, name in enumerate(("nest", "prey")):
        known = stacked(scenes, lambda s, area=area: s.known[:, area])
        assert_array_equal(columns["known"].astype(int) >> area & 1, known)
        p = stacked(scenes, lambda s, area=area: s.p[:, area])
        assert_allclose(columns[f"{name}P"], p, atol=0.00251)
        for axis, letter in enumerate("XY"):
            place = stacked(scenes, lambda s, area=area, axis=axis: s.believed[:, area, axis])
            assert_allclose(columns[name + letter], place, atol=0.00101)


def test_an_episode_is_read_back_within_its_rounding(scenes):
    times, on_path, heard, columns = unpacked(*recorded(scenes).pack())
    assert_allclose(times, [scene.time for scene in scenes], atol=1e-4)
    assert_allclose(on_path, [scene.on_path for scene in scenes], atol=1e-6)
    check_columns(columns, scenes)
    assert heard == [set(map(tuple, scene.messages.tolist())) for scene in scenes]
    assert any(heard)


@pytest.mark.parametrize("every", [2, 8, 49, 64])
def test_what_is_heard_between_the_frames_is_in_the_later(made_up, every):
    scenes = [made_up(tick) for tick in range(50)]
    times, _, heard, columns = unpacked(*recorded(scenes, every).pack())
    kept = sorted({*range(0, 50, every), 49})
    assert_allclose(times, [0.1 * tick for tick in kept], atol=1e-5)
    check_columns(columns, [scenes[tick] for tick in kept])
    for before, frame, pairs in zip([-1, *kept[:-1]], kept, heard, strict=True):
        between = [scenes[tick].messages for tick in range(before + 1, frame + 1)]
        assert pairs == set(map(tuple, np.concatenate(between).tolist()))


def test_places_too_far_apart_for_fine_steps_get_coarser_ones(made_up):
    far = made_up(1)
    far.pose[0, 0] = 1000.0
    about, packed = recorded([made_up(0), far]).pack()
    x = unpacked(about, packed)[3]["x"]
    assert about["columns"][0]["step"] == pytest.approx(1000.0 / 65535, rel=0.01)
    assert x[0] == pytest.approx([made_up(0).pose[0, 0], 1000.0], abs=0.01)


def test_robots_that_hear_nothing_are_recorded(made_up):
    silent = replace(made_up(0), messages=np.zeros((0, 2), np.int32))
    assert unpacked(*recorded([silent]).pack())[2] == [set()]


def test_scenes_come_in_order_and_nothing_recorded_cannot_be_packed(made_up):
    with pytest.raises(ConfigError, match=r"scene of 0.3 s after one of 0.3 s"):
        recorded([made_up(3), made_up(3)])
    with pytest.raises(ConfigError, match="no scene was recorded"):
        Recording().pack()


def test_faults_are_kept_where_robots_may_be_faulty(made_up):
    faulty = [np.array([tick >= 3, False, True]) for tick in range(6)]
    scenes = [replace(made_up(tick), faulty=own) for tick, own in enumerate(faulty)]
    *_, columns = unpacked(*recorded(scenes).pack())
    assert_array_equal(columns["faulty"], np.transpose(faulty))
    *_, columns = unpacked(*recorded([made_up(0), made_up(1)]).pack())
    assert "faulty" not in columns
