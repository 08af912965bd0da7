"""A playground runs worlds in Chromium as they run here, bit for bit as far as it shows them."""

import json
import shlex
from base64 import b64decode

import numpy as np
import pytest

from baselines.evaluation.episode import run_episodes
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.play import write_playground
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.envs.decision import Observing
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KEEP
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from tests.chromium import CHROMIUM, MISSING, launched_browser  # noqa: F401 the fixture browser
from tests.networks import any_network
from tests.rendering.replay.pages import parts
from tests.rendering.replay.test_browser import LOADED, opened, until  # noqa: F401 a fixture

CONTROLLERS = "ssgiff", "learned-both"
SHORT = "task.duration=600"
WALLS = [{"points": [[x, -0.1], [x, 0.1]], "radius": 0.01} for x in (-0.425, 0.425)]


def in_chromium(test):
    """A test that needs it."""
    return pytest.mark.browser(pytest.mark.skipif(CHROMIUM is None, reason=MISSING)(test))


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    pytest.importorskip("ziglang", reason="pip install 'swarm-forage[play]'")
    found = tmp_path_factory.mktemp("page") / "play.html"
    settings = [SHORT, "n_robots=10"]
    write_playground(EvaluateOptions("es1", CONTROLLERS, 1, 0, settings, "kinematic"), found)
    return found


@pytest.fixture
def page(opened, file):  # noqa: F811 the fixture
    return opened(path=file)


def trips_here(seed, numbers=None, changes=""):
    scenario = find_scenario("es1", {"task.duration": 600.0, **(numbers or {})})
    names = [CONTROLLERS[0] + changes, CONTROLLERS[1]]
    ran = (run_episodes(scenario, find_controller(each), [seed], "kinematic") for each in names)
    return [episode.round_trips for (episode,) in ran]


RECORDED = "(player.seek(60), Array.from({ length: 10 }, (_, i) => robotAt(i).x))"
TRIPS = "view.episodes.map(({ total }) => total[about.frames - 1])"


@in_chromium
def test_the_page_makes_the_round_trips_that_evaluate_makes(page):
    for seed in (2, 2**53 - 1, 0):
        page.fill("#seed", str(seed))
        page.press("#seed", "Enter")
        until(page, f"location.hash === '#seed={seed}' && live.waiting.size === 0")
        assert page.evaluate(TRIPS) == trips_here(seed)


CHOSEN = {
    "&radio.max_range=0.3&weighting.beta=0.02": ({"radio.max_range": 0.3}, ":beta=0.02"),
    "&task.n_robots=50": ({"task.n_robots": 50, "task.start_radius": 0.354}, ""),
    "&task.n_robots=20&faults.liar.share=0.3": (
        {"task.n_robots": 20, "faults.liar.share": 0.3}, ""),
    "&obstacles=1": ({"obstacles": json.dumps(WALLS)}, ""),
}  # fmt: skip
"""Addresses, and what they change of the scenario and of the first controller."""


@in_chromium
@pytest.mark.parametrize("address", CHOSEN)
def test_an_address_chooses_seed_and_numbers(opened, file, address):  # noqa: F811 the fixture
    page = opened(path=file)
    page.goto("about:blank")
    page.goto(f"{file.as_uri()}#seed=1{address}&t=300")
    until(page, LOADED)
    numbers, changes = CHOSEN[address]
    assert page.evaluate("view.time") == 300
    assert page.evaluate(TRIPS) == trips_here(1, numbers, changes)
    command_line = shlex.split(page.evaluate("element('command').textContent"))
    assert command_line[:3] == ["swarm-forage", "evaluate", "es1"]
    assert {f"{name}={value}" for name, value in numbers.items()} <= {*command_line}
    assert sum("n_robots=" in word for word in command_line) == 1, "no setting is given twice"
    assert page.evaluate("arena.robotNear(...arena.place(robotAt(4).x, robotAt(4).y))") == 4


@in_chromium
def test_a_visitor_drives_a_robot_as_a_learner_does_and_sees_what_it_sees(page):
    page.evaluate("player.play = () => {}")  # ticks are run by this test alone
    page.evaluate("view.chosen = 3; player.seek(60)")
    page.evaluate("drive.takeOver()")
    until(page, "view.driving?.now != null")
    ticks = page.evaluate("Math.round(view.time / about.tick)")
    page.evaluate("drive.ask('drive', { robot: 3, wheels: [0.25, 1], ticks: 7 })")
    until(page, f"Math.round(view.time / about.tick) === {ticks + 7}")
    loop = Loop(find_scenario("es1"), find_controller(CONTROLLERS[0]), [0], "kinematic")
    form = PolicyForm([loop.world.scenario], EnvConfig(learn="motion"))
    loop.run(ticks)
    action = loop.world.robots["action"]
    form.mark_replaced_layers(action, dict.fromkeys(("motion", "weighting"), (0, 3)))
    action["wheels"][0, 3] = 0.25, 1.0
    loop.run(7)
    own, raw = Loop.memory.to_device(np.zeros(1, np.int8)), np.zeros((1, 1, 2), np.float32)
    observed = Observing(form, loop, np.array([3]))(raw, own, np.ones(1))
    assert page.evaluate("Array.from(view.driving.observed)") == observed.ravel().tolist()
    shown = page.evaluate("[robotAt(3).x, robotAt(3).y, robotAt(9).x]")
    poses = loop.world.robots["pose"][0].astype(np.float32)
    assert shown == [poses[3, 0], poses[3, 1], poses[9, 0]]
    page.evaluate("drive.letGo()")
    until(page, "live.waiting.size === 0 && view.driving === null")
    action["motion"][0, 3], action["has_reflexes"][0, 3] = KEEP, False
    action["is_walking"][0, 3], action["wheels"][0, 3] = False, 0.0
    loop.run(6000 - ticks - 7)
    assert page.evaluate(TRIPS)[0] == loop.world.robots["round_trips"].sum()


@in_chromium
def test_without_web_assembly_a_recording_is_played(browser, file):
    page = browser.new_page()
    page.add_init_script("delete WebAssembly")
    page.goto(file.as_uri())
    until(page, LOADED)
    assert page.evaluate("view.end") == 300
    assert "no WebAssembly" in page.inner_text("#notice")
    assert page.evaluate(TRIPS) == trips_here(0, {"task.duration": 300.0})
    page.close()


def test_no_two_sliders_write_the_same_bytes(file):
    about, _ = parts(file.read_text())
    for swarm in (about, *about["beside"]):
        written = {
            name: {
                at + k for each in several for at, put in each for k in range(len(b64decode(put)))
            }
            for name, several in swarm["patches"].items()
        }
        assert sum(map(len, written.values())) == len(set.union(*written.values())) > 0


@in_chromium
def test_the_page_draws_the_scene_of_a_moment(page):
    loop = Loop(find_scenario("es1"), find_controller(CONTROLLERS[0]), [0], "kinematic")
    loop.run(3000)
    scene = loop.scene()

    def shown(name):
        column = f"Array.from({{ length: 10 }}, (_, i) => e.{name}[i * about.frames + 300])"
        return np.array(page.evaluate(f"((e) => {column})(view.episodes[0])"), np.float32)

    expected = {
        "x": scene.pose[:, 0],
        "y": scene.pose[:, 1],
        "heading": scene.pose[:, 2],
        "doing": scene.activity,
        "known": scene.known[:, NEST] + 2 * scene.known[:, PREY],
        "trips": scene.round_trips,
        "nestX": scene.believed[:, NEST, 0],
        "preyY": scene.believed[:, PREY, 1],
        "preyP": scene.p[:, PREY],
    }
    for name, values in expected.items():
        assert (shown(name) == values.astype(np.float32)).all(), name
    assert page.evaluate("view.episodes[0].share[300]") == np.float32(scene.on_path)
    heard = page.evaluate("Array.from(view.episodes[0].pairs.slice(0, 60))")
    assert len(heard) == 60
    assert max(heard) < 10


AHEAD = "import numpy as np\ndef ahead(seen): return np.zeros((len(seen), 2), np.float32)\n"


@pytest.mark.parametrize(
    ("scenario", "controllers", "refusal"),
    [
        ("waypoints-05", ["boids-adaptive"], "foraging scenarios only, such as es1; watch --html"),
        ("es1", ["nc", "ssgikf", "ssgiff"], "3 controllers: a page shows at most 2"),
        ("es1", ["{motion},chance=true"], "runs in Python only, because it is stochastic"),
        ("es1", ["{weighting},step_on=exchange"], "because its memory advances at exchanges"),
        ("es1", ["{everything}"], "a page draws the beliefs of robots"),
        ("es1", ["callable:my_policy:ahead"], "runs in Python only; networks that swarm-forage"),
    ],
)
def test_what_a_page_cannot_run_is_refused(scenario, controllers, refusal, tmp_path, monkeypatch):
    (tmp_path / "my_policy.py").write_text(AHEAD)
    monkeypatch.syspath_prepend(tmp_path)
    names = {}
    for learn, n_state in (("motion", 8), ("weighting", 8), ("everything", 0)):
        (tmp_path / learn).mkdir()
        names[learn] = any_network(tmp_path / learn, n_state, learn)
    asked = [controller.format(**names) for controller in controllers]
    with pytest.raises(ConfigError, match=refusal):
        write_playground(EvaluateOptions(scenario, asked, 2), tmp_path / "x.html")
    assert not (tmp_path / "x.html").exists()


@in_chromium
def test_a_network_that_ppo_trained_acts_in_the_page_as_here(opened, tmp_path):  # noqa: F811 the fixture
    pytest.importorskip("ziglang", reason="pip install 'swarm-forage[play]'")
    file, folder = tmp_path / "play.html", tmp_path / "my networks"
    folder.mkdir()
    network = any_network(folder, 8)
    short = EvaluateOptions("es1", [network], 1, 0, ["task.duration=60"], "kinematic")
    write_playground(short, file)
    page = opened(path=file)
    assert network in shlex.split(page.evaluate("element('command').textContent"))
    loop = Loop(find_scenario("es1"), find_controller(network), [0], "kinematic")
    loop.run(600)
    shown = page.evaluate("Array.from({ length: 10 }, (_, i) => view.episodes[0].x[i * 61 + 60])")
    x = loop.world.robots["pose"][0, :, 0].astype(np.float32)
    assert shown == x.tolist()
    page = opened(path=file, before="delete WebAssembly")
    np.testing.assert_allclose(page.evaluate(RECORDED), x, atol=1e-3)
