"""A replay plays in a browser, from disk, without a network."""

import io
import re
import time
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.replay import Opening, Replay
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import stage_of
from tests.chromium import CHROMIUM, MISSING, launched_browser  # noqa: F401 the fixture browser
from tests.rendering.scenes import AREAS, CORNERS, OBSTACLES, scenes_of

pytestmark = [pytest.mark.browser, pytest.mark.skipif(CHROMIUM is None, reason=MISSING)]
DESKTOP, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
COLOURS = "#882255", "#bbbbbb"
"""Of two controllers: one is dark, the other is light."""
LOADED = "view.episode !== null"
DRAWN = """new Promise((done, fail) => {
    requestAnimationFrame(() => requestAnimationFrame(done));
    setTimeout(() => fail(new Error("nothing was drawn in 30 s")), 30000);
})"""


@pytest.fixture(scope="module")
def file(stage, scenes, tmp_path_factory):
    replay = Replay(stage, 1, "swarm-forage watch es1 ssgikf --seed=1")
    for scene in scenes:
        replay.add(scene)
    found = tmp_path_factory.mktemp("replay") / "a replay.html"
    replay.write(found)
    return found


@pytest.fixture
def opened(browser, file):
    """Opens the file as a user does; in the end nothing was fetched and nothing complained."""
    contexts, complaints, requests = [], [], []

    def open_(size=DESKTOP, scheme="light", before="", path=file, loads=True, **more):
        context = browser.new_context(viewport=size, color_scheme=scheme, offline=True, **more)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.add_init_script(before)
        page.goto(path.as_uri())
        if loads:
            until(page, LOADED)
            page.evaluate(DRAWN)
        return page

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []
    assert not [url for url in requests if not url.startswith(("blob:", "data:", "file:"))]


@pytest.fixture
def page(opened):
    return opened()


def until(page, truth):
    """Wait for something to be true; the page forbids the `eval` of wait_for_function."""
    end = time.monotonic() + 30.0
    while not page.evaluate(truth):
        assert time.monotonic() < end, f"never: {truth}"
        page.wait_for_timeout(20)


def clock(page):
    return page.locator("#clock").inner_text()


def scrub(page, seconds):
    page.locator("#time").fill(str(seconds))
    page.evaluate(DRAWN)


def places(page):
    """x, y [m] of every robot as the page has them now."""
    each = "(_, i) => { const robot = robotAt(i); return [robot.x, robot.y]; }"
    return np.array(page.evaluate(f"Array.from({{ length: about.robots }}, {each})"))


def on_screen(page, points):
    """World [m] to pixels of the page."""
    box = page.locator("#arena").bounding_box()
    place = "(points) => points.map((point) => arena.place(...point))"
    spots = page.evaluate(place, np.asarray(points).tolist())
    return np.add(spots, (box["x"], box["y"]))


def picture_of(page):
    """A screenshot of the page, or of a part of it."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))


def pixels(page, points):
    """Colours at places of the world, in a screenshot of the page."""
    picture = picture_of(page)
    return [tuple(picture[round(y), round(x)].tolist()) for x, y in on_screen(page, points)]


def alike(colour, other, by=6):
    return max(abs(a - b) for a, b in zip(colour, other, strict=True)) <= by


def readable(scenes, stage):
    """A scene and a robot that believes the nest to be in a spot where nothing else is drawn."""
    for tick, scene in list(enumerate(scenes))[::5]:
        for robot in np.flatnonzero(scene.known.all(axis=1)):
            spot, places = scene.believed[robot, 0], scene.pose[:, :2]
            others = np.delete(places, robot, 0) - places[robot]
            nearest = np.hypot(*np.concatenate([places - spot, others]).T).min()
            near = np.hypot(*(spot - stage.areas[0])) < 0.5 * stage.area_radius
            if near and nearest > 3.0 * stage.robot_radius:
                return tick, int(robot)
    raise AssertionError("no such scene in this episode")


def test_it_plays_and_pauses(page):
    assert clock(page).startswith("0:00")
    before = places(page)
    page.get_by_role("button", name="Play").click()
    until(page, "view.time > 3")
    page.get_by_role("button", name="Pause").click()
    page.evaluate(DRAWN)
    stopped = page.evaluate("view.time")
    assert not clock(page).startswith("0:00")
    assert float(page.locator("#time").input_value()) == pytest.approx(stopped, abs=0.06)
    assert np.abs(places(page) - before).max() > 0.02
    page.evaluate(DRAWN)
    assert page.evaluate("view.time") == stopped


def test_it_stops_at_the_end_and_plays_again_from_the_start(page):
    page.get_by_label("Speed").select_option("100")
    scrub(page, 149)
    page.get_by_role("button", name="Play").click()
    until(page, "!view.playing")
    assert clock(page).startswith("2:30")
    page.get_by_role("button", name="Play").click()
    until(page, "view.playing && view.time < 100")


@pytest.mark.parametrize("tick", [0, 437, 1500])
def test_scrubbing_moves_time_and_robots(page, scenes, tick):
    scrub(page, 60)
    scrub(page, tick / 10)
    seconds = tick // 10
    assert clock(page).split(" / ")[0] == f"{seconds // 60}:{seconds % 60:02d}"
    assert places(page) == pytest.approx(scenes[tick].pose[:, :2], abs=0.001)
    assert page.locator("#trips").inner_text() == str(scenes[tick].total)
    assert page.locator("#on-path").inner_text() == f"{100 * scenes[tick].on_path:.0f}%"
    counts = [int(text) for text in page.locator("#legend b").all_inner_texts()]
    assert counts == np.bincount(scenes[tick].activity, minlength=5).tolist()


def test_between_two_frames_robots_are_between_two_places(page, scenes):
    page.evaluate("player.seek(80.05)")
    middle = 0.5 * (scenes[800].pose[:, :2] + scenes[801].pose[:, :2])
    assert places(page) == pytest.approx(middle, abs=0.0015)


def test_the_curves_can_be_dragged(page):
    box = page.locator("#curves").bounding_box()
    middle = box["x"] + page.evaluate("curves.x(75)"), box["y"] + 60
    page.mouse.move(box["x"] + 60, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(*middle)
    page.mouse.up()
    assert page.evaluate("view.time") == pytest.approx(75.0, abs=0.3)


def test_hovering_over_a_robot_shows_what_it_believes_and_hears(page, scenes, stage):
    tick, robot = readable(scenes, stage)
    scene, card = scenes[tick], page.locator("#robot-card")
    scrub(page, tick / 10)
    for name in ("Trails", "Messages"):
        page.get_by_role("button", name=name).click()
    (before,) = pixels(page, [scene.believed[robot, 0]])
    assert "Point at a robot" in card.inner_text()
    page.mouse.move(*on_screen(page, [scene.pose[robot, :2]])[0])
    page.evaluate(DRAWN)
    rows = card.locator("tr").all_inner_texts()
    off = np.hypot(*(scene.believed[robot] - stage.areas).T)
    for area, name in enumerate(("nest", "prey")):
        (row,) = (row for row in rows if row.startswith(name))
        numbers = [float(number) for number in re.findall(r"([\d.]+) m", row)]
        assert numbers == pytest.approx([off[area], scene.p[robot, area]], abs=0.012)
    (heard,) = (row for row in rows if row.startswith("hears"))
    recent = [each.messages for each in scenes[tick - 4 : tick + 1]]
    senders = sorted({int(a) for pairs in recent for a, b in pairs if b == robot})
    assert [int(number) for number in re.findall(r"\d+", heard)] == senders
    (after,) = pixels(page, [scene.believed[robot, 0]])
    assert not alike(before, palette.AREA[0], 80)
    assert alike(after, palette.AREA[0], 80)  # a thin line, which may lie between two pixels
    page.mouse.move(2, 2)
    page.evaluate(DRAWN)
    assert "Point at a robot" in card.inner_text()


@pytest.mark.parametrize(("scheme", "brightness"), [("light", 1.0), ("dark", 0.8)])
def test_a_picture_shows_areas_and_robots_where_they_are(opened, scenes, stage, scheme, brightness):
    page = opened(scheme=scheme)
    for name in ("Trails", "Messages"):
        page.get_by_role("button", name=name).click()
    page.evaluate(DRAWN)
    tinted = [palette.mixed(colour, palette.FLOOR, 0x38 / 255) for colour in palette.AREA]
    corner = 0.45 * stage.length, 0.45 * stage.width
    colours = brightness * np.array([*tinted, palette.FLOOR])
    assert all(map(alike, pixels(page, [*stage.areas, corner]), colours))
    seen = set()
    for tick in (0, 600, 1200):
        scrub(page, tick / 10)
        x, y, heading = scenes[tick].pose.T
        back = 0.55 * stage.robot_radius
        tails = np.stack([x - back * np.cos(heading), y - back * np.sin(heading)], axis=1)
        above = y > 0.0  # below are the names of areas
        for colour, activity in zip(
            pixels(page, tails[above]), scenes[tick].activity[above], strict=True
        ):
            assert alike(colour, brightness * np.array(palette.ROBOT[int(activity)]))
            seen.add(int(activity))
    assert len(seen) >= 3


@pytest.fixture
def still(opened, made_up, tmp_path):
    """Opens a page of three robots that stand in a changed es1."""

    def open_(ticks, **changes):
        replay = Replay(stage_of(find_scenario("es1", {"n_robots": 3} | changes), "nc"), 1, "")
        away = np.array([[x, 0.0, 0.0] for x in (-0.3, 0.0, 0.3)])
        for tick in ticks:
            replay.add(replace(made_up(tick), pose=away))
        replay.write(tmp_path / "still.html")
        return opened(path=tmp_path / "still.html")

    return open_


def test_a_picture_shows_obstacles_and_the_outer_wall_where_they_are(still):
    page = still([0], **{"obstacles": OBSTACLES, "arena.corners": CORNERS})
    walls = [(0.3, 0.3), (0.3, 0.4), (-0.3, 0.4), (-0.3, 0.49), (0.0, -0.4)]
    assert all(alike(each, palette.WALL) for each in pixels(page, walls))
    floor = [(0.35, 0.3), (-0.3, 0.52), (0.2, -0.4), (0.7, -0.5)]
    assert all(alike(each, palette.FLOOR) for each in pixels(page, floor))
    (beyond,) = pixels(page, [(0.83, -0.58)])
    assert not alike(beyond, palette.FLOOR)


def test_a_picture_shows_several_areas_and_the_move_of_one(still):
    page = still(range(0, 601, 10), **{"task.areas": AREAS})
    nest, prey = (palette.mixed(colour, palette.FLOOR, 0x38 / 255) for colour in palette.AREA)
    for seconds, up, down in ((49.0, prey, palette.FLOOR), (51.0, palette.FLOOR, prey)):
        scrub(page, seconds)
        places = [(0.7, 0.36), (0.7, -0.24), (-0.7, 0.06), (-0.5, 0.46)]
        for seen, colour in zip(pixels(page, places), (up, down, nest, nest), strict=True):
            assert alike(seen, colour)
    off = page.evaluate("nearestArea(0, { x: -0.4, y: 0.2 })")
    assert off == [-0.5, 0.4]


def test_robots_that_visit_goals_show_what_they_are_about(opened, tmp_path):
    loop = Loop(find_scenario("waypoints-05"), find_controller("boids-adaptive"), [1])
    replay = Replay(stage_of(loop.world.scenario, "boids-adaptive"), 1, "")
    scenes = scenes_of(loop, 119)
    for each in scenes:
        replay.add(each)
    replay.write(tmp_path / "goals.html")
    page = opened(path=tmp_path / "goals.html")
    assert page.locator("#score-name").inner_text() == "Goals reached"
    scrub(page, 59.5)
    last, own = scenes[-1], scenes[-1].localised
    assert page.locator("#trips").inner_text() == str(last.total)
    assert page.locator("#on-path").inner_text() == f"{100 * last.share:.0f}%"
    page.evaluate("player.choose(2)")
    page.evaluate(DRAWN)
    rows = dict(row.split("\t") for row in page.locator("#robot-card tbody tr").all_inner_texts())
    off = np.hypot(*(own.believed[2] - last.pose[2, :2]))
    assert float(rows["believed"].split()[0]) == pytest.approx(off, abs=0.01)
    assert rows["claimed rightly"] == str(own.right[2])
    claims = page.evaluate("claimsNow().filter((claim) => claim.right).length")
    assert claims == (own.right - scenes[-41].localised.right).sum()
    assert page.evaluate("claimsNow().length") >= claims
    spots = own.goal + np.array([loop.world.scenario.task.tolerance, 0.0])
    assert any(alike(colour, palette.GOAL, 60) for colour in pixels(page, spots))


@pytest.fixture(scope="module")
def compared(stage, scenes, busy, tmp_path_factory):
    """A replay of two swarms from 60 s on, and the scenes of the second."""
    others = scenes_of(Loop(busy, find_controller("nc"), [1]), len(scenes) - 1)
    opening = Opening(start=60.0, speed=20.0, select=3, second_controller="nc", colours=COLOURS)
    replay = Replay(stage, 1, "", opening=opening)
    for first, second in zip(scenes[400:], others[400:], strict=True):
        replay.add(first)
        replay.add(second, 1)
    found = tmp_path_factory.mktemp("compared") / "two.html"
    replay.write(found)
    return found, others


def test_two_swarms_play_side_by_side(opened, compared, scenes, stage):
    file, others = compared
    page = opened(path=file)
    assert page.evaluate("[view.time, view.speed, view.chosen]") == pytest.approx([60, 20, 3])
    assert page.locator("h1").inner_text() == "es1 · ssgikf and nc · seed 1"
    assert page.locator("figcaption").all_inner_texts() == ["ssgikf", "nc"]
    boxes = [canvas.bounding_box() for canvas in page.locator("figure canvas").all()]
    assert boxes[0]["x"] + boxes[0]["width"] <= boxes[1]["x"]
    assert boxes[0]["y"] == boxes[1]["y"]
    aspect = boxes[0]["width"] / boxes[0]["height"]
    assert aspect == pytest.approx(stage.length / stage.width, rel=0.05), "no gaps"
    scrub(page, 120)
    words = page.locator("#trips span").all_inner_texts()
    assert words == [str(each[1200].total) for each in (scenes, others)]
    for which, own in enumerate((scenes, others)):
        counts = page.locator(f"#legend b.swarm-{which}").all_inner_texts()
        assert list(map(int, counts)) == np.bincount(own[1200].activity, minlength=5).tolist()
        page.evaluate(f"view.swarm = {which}")
        assert places(page) == pytest.approx(own[1200].pose[:, :2], abs=0.001)
    page.evaluate("view.swarm = 0")
    captions = page.locator("#robot-card caption").all_inner_texts()
    assert captions == ["ssgikf", "nc"]
    page.evaluate("player.choose(null)")
    page.get_by_role("button", name="Trails").click()
    page.evaluate(DRAWN)
    picture = picture_of(page)
    x, y = page.evaluate(f"arena.place({0.45 * stage.length}, {0.45 * stage.width})")
    for box in boxes:
        spot = picture[round(box["y"] + y), round(box["x"] + x)]
        assert alike(spot.tolist(), palette.FLOOR)
    page.keyboard.press("Home")
    page.keyboard.press(",")
    assert page.evaluate("view.time") == pytest.approx(60.0), "what is before is for trails alone"
    page.evaluate("element('arenas').style.setProperty('--aspect', '1 / 4')")
    tall, curves = (page.locator(each).bounding_box() for each in ("#arena", "#curves"))
    assert tall["y"] + tall["height"] <= curves["y"], "a tall arena is not drawn over the curves"


NAMED = "figcaption", "#robot-card caption", "#legend em", "#trips span", "#on-path span"
BARS = """(each) => [...document.querySelectorAll(each)].map((bar) =>
    getComputedStyle(bar, "::before").backgroundImage.match(/rgb\\([^)]*\\)/)[0])"""


def test_whatever_is_of_a_controller_has_its_colour(opened, compared):
    page = opened(path=compared[0])
    for each in NAMED:
        assert page.evaluate(BARS, each) == ["rgb(136, 34, 85)", "rgb(187, 187, 187)"]
    for moment, n_least in ((60, 20), (120, 50)):
        scrub(page, moment)
        for colour in (136, 34, 85), (187, 187, 187):
            curves = np.all(picture_of(page.locator("#curves")) == colour, axis=2)
            assert curves.sum() > n_least


def test_a_tap_chooses_a_robot(opened):
    page = opened(PHONE, has_touch=True, is_mobile=True)
    card, footer = (page.locator(each).bounding_box() for each in ("#robot-card", "footer"))
    assert "Tap a robot" in page.locator("#robot-card").inner_text()
    assert footer["y"] - card["y"] - card["height"] < 40, "no gap"
    ((x, y),) = on_screen(page, [page.evaluate("[robotAt(2).x, robotAt(2).y]")])
    page.touchscreen.tap(x, y)
    assert page.evaluate("view.chosen") == 2


@pytest.mark.parametrize(
    ("scheme", "edges"), [("light", ["", "var(--faint)"]), ("dark", ["var(--faint)", ""])]
)
def test_a_colour_like_that_of_the_page_has_an_edge(opened, compared, scheme, edges):
    page = opened(path=compared[0], scheme=scheme)
    edge = "(k) => document.documentElement.style.getPropertyValue(`--edge-${k}`)"
    for which, (wanted, own) in enumerate(zip(edges, COLOURS, strict=True)):
        assert page.evaluate(edge, which) == (wanted or own)


def test_trails_go_back_before_the_start(opened, compared, scenes):
    page = opened(path=compared[0])
    page.get_by_role("button", name="Messages").click()
    page.evaluate("player.choose(null)")
    page.evaluate(DRAWN)
    way = np.stack([scene.pose[:, :2] for scene in scenes[400:600:10]])
    far = [robot for robot in range(10) if np.ptp(way[:, robot], axis=0).max() > 0.3]
    spots = way[-6:-3, far].reshape(-1, 2)
    before = pixels(page, spots)
    page.get_by_role("button", name="Trails").click()
    page.evaluate(DRAWN)
    changed = [not alike(a, b) for a, b in zip(before, pixels(page, spots), strict=True)]
    assert np.mean(changed) > 0.5


@pytest.mark.parametrize("size", [PHONE, DESKTOP])
def test_no_name_is_over_a_robot_or_another_name(opened, size, scenes, stage):
    page = opened(size)
    page.evaluate("player.choose(4)")
    seen = set()
    for tick in range(0, len(scenes), 75):
        scrub(page, tick / 10)
        boxes = page.evaluate("labels.boxes[0]")
        seen |= {box["text"] for box in boxes}
        spots = page.evaluate(
            "Array.from({ length: about.robots }, (_, i) => {"
            " const { x, y } = robotAt(i); return arena.place(x, y); })"
        )
        radius = page.evaluate("arena.robotSize")
        for box in boxes:
            left, top = box["left"], box["top"]
            right, bottom = left + box["width"], top + box["height"]
            for robot, (x, y) in enumerate(spots):
                if box["text"] == "robot 4" and robot == 4:
                    continue
                apart = np.hypot(x - np.clip(x, left, right), y - np.clip(y, top, bottom))
                assert apart > radius, (tick, box["text"], robot)
        assert len({box["text"] for box in boxes}) == len(boxes)
    assert {"nest", "prey", "start", "robot 4"} <= seen


def test_keys_do_what_the_page_says(page):
    def press(*keys):
        for key in keys:
            page.keyboard.press(key)
        page.evaluate(DRAWN)
        return page.evaluate("[view.time, view.chosen, view.speed]")

    assert press("ArrowRight") == pytest.approx([5.0, None, 10], abs=1e-3)
    assert press("Shift+ArrowRight", "ArrowLeft")[0] == pytest.approx(60.0)
    assert press("Period", "Period", "Comma")[0] == pytest.approx(60.1)
    assert press("End")[0] == pytest.approx(150.0)
    assert press("Home")[0] == 0.0
    assert press("+")[2] == 20
    assert press("ArrowDown", "-")[2] == 5
    assert press("]", "]")[1] == 1
    assert page.locator("#robot").input_value() == "1"
    assert press("[", "[")[1] == 9
    assert press("Escape")[1] is None
    for key, name in (("t", "Trails"), ("m", "Messages"), ("b", "All beliefs")):
        button = page.get_by_role("button", name=name)
        before = button.get_attribute("aria-pressed")
        press(key)
        assert button.get_attribute("aria-pressed") != before
    press("Space")
    until(page, "view.playing && view.time > 0")
    press("Space")
    assert not page.evaluate("view.playing")


def test_everything_that_can_be_used_has_a_name(page):
    for role, names in {
        "button": ("Play", "One frame back", "One frame on", "Trails", "Messages", "All beliefs"),
        "slider": ("Time in the episode",),
        "combobox": ("Speed", "Robot"),
        "img": ("Top view of the arena", "Round trips of the swarm"),
    }.items():
        for name in names:
            assert page.get_by_role(role, name=name).count() == 1
    slider = page.get_by_role("slider")
    scrub(page, 75)
    assert slider.get_attribute("aria-valuetext") == "1:15 of 2:30"


@pytest.mark.parametrize("size", [PHONE, DESKTOP, {"width": 1920, "height": 1080}])
def test_it_fits_the_window(opened, size, stage):
    page = opened(size)
    assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
    if size != PHONE:
        assert page.evaluate("document.documentElement.scrollHeight") <= size["height"]
    half = 0.5 * np.array([stage.length, stage.width])
    box = page.locator("#arena").bounding_box()
    (left, bottom), (right, top) = on_screen(page, [-half, half])
    assert box["x"] <= left < right <= box["x"] + box["width"]
    assert box["y"] <= top < bottom <= box["y"] + box["height"]
    assert (right - left) / (bottom - top) == pytest.approx(stage.length / stage.width)
    assert right - left > 0.5 * size["width"]


def test_a_browser_too_old_and_a_damaged_file_are_told(opened, file):
    text, damaged = file.read_text(encoding="utf-8"), file.with_name("damaged.html")
    start = text.index(">", text.index('id="recording-0"')) + 1
    damaged.write_text(text[: start + 400] + text[start + 800 :])
    too_old = {"before": "delete window.DecompressionStream"}
    for given, words in ((too_old, "too old"), ({"path": damaged}, "cannot be read")):
        notice = opened(**given, loads=False).get_by_role("alert")
        notice.wait_for()
        assert words in notice.inner_text()
