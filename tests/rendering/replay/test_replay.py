"""A replay is one file that stands alone, tells what it shows, and appears whole or not at all."""

import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from swarm_forage_env.errors import ConfigError
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
        told = re.search(f"<{tag}>(.*?)</{tag}>", page)[1]
        assert html.unescape(told) == f"es1 · {name} · seed 1"
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


def test_a_smaller_budget_keeps_fewer_frames(stage, scenes):
    sizes = []
    for budget in (BUDGET, 40_000):
        replay = Replay(stage, 1, COMMAND, budget)
        for scene in scenes:
            replay.add(scene)
        about, packed = parts(replay.page())
        times = unpacked(about, packed)[0]
        assert times[1] - times[0] == pytest.approx(about["every"] * stage.tick, abs=1e-4)
        sizes.append((about["every"], len(packed)))
    assert sizes[0][0] == 1
    assert sizes[1][0] == 8
    assert sizes[1][1] * 4 / 3 < 40_000


def test_a_file_is_replaced_as_a_whole(replay, tmp_path):
    file = tmp_path / "x.html"
    file.write_text("before")
    replay.write(file)
    assert file.read_text(encoding="utf-8") == replay.page()
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("name", ["file/x.html", "folder"])
def test_a_file_that_cannot_be_written_is_refused_in_one_line(replay, tmp_path, name):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    with pytest.raises(ConfigError, match=r"cannot be written \(.+\)$") as refused:
        replay.write(tmp_path / name)
    assert "\n" not in str(refused.value)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "folder"]
