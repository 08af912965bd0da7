"""A playground runs worlds in Chromium as they run here, bit for bit as far as it shows them."""

import numpy as np
import pytest

from baselines.evaluation.episode import run_episodes
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.play import write_playground
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from tests.chromium import CHROMIUM, MISSING, launched_browser  # noqa: F401 the fixture browser
from tests.rendering.replay.test_browser import LOADED, opened, until  # noqa: F401 a fixture

CONTROLLERS = "ssgiff", "learned-both"
SHORT = "task.duration=600"
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason=MISSING)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    pytest.importorskip("ziglang", reason="pip install 'swarm-forage[play]'")
    found = tmp_path_factory.mktemp("page") / "play.html"
    options = EvaluateOptions("es1", CONTROLLERS, 4, 0, [SHORT], "kinematic")
    write_playground(options, found)
    return found


@pytest.fixture
def page(opened, file):  # noqa: F811 the fixture
    found = opened(path=file)
    until(found, LOADED)
    return found


def trips_here(seed, numbers=None, changes=""):
    scenario = find_scenario("es1", {"task.duration": 600.0, **(numbers or {})})
    names = [CONTROLLERS[0] + changes, CONTROLLERS[1]]
    ran = (run_episodes(scenario, find_controller(each), [seed], "kinematic") for each in names)
    return [episode.round_trips for (episode,) in ran]


TRIPS = "view.episodes.map(({ total }) => total[about.frames - 1])"


@pytest.mark.browser
@needs_chromium
def test_the_page_makes_the_round_trips_that_evaluate_makes(page):
    for seed in (0, 2, 3):
        page.select_option("#seed", str(seed))
        until(page, f"location.hash === '#seed={seed}' && live.waiting.size === 0")
        assert page.evaluate(TRIPS) == trips_here(seed)


@pytest.mark.browser
@needs_chromium
def test_an_address_chooses_seed_and_numbers(opened, file):  # noqa: F811 the fixture
    address = f"{file.as_uri()}#seed=1&radio.max_range=0.3&weighting.beta=0.02"
    page = opened(path=file)
    page.goto(address)
    page.reload()
    until(page, LOADED)
    assert page.evaluate("element('radio.max_range-value').textContent") == "0.3 m"
    assert page.evaluate(TRIPS) == trips_here(1, {"radio.max_range": 0.3}, ":beta=0.02")


@pytest.mark.browser
@needs_chromium
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
        "doing": scene.doing,
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


@pytest.mark.parametrize(
    ("scenario", "controllers", "refusal"),
    [("waypoints-05", ["boids-adaptive"], "worlds that forage alone"),
     ("es1", ["nc", "ssgikf", "ssgiff"], "3 controllers: a page shows 2")],
)  # fmt: skip
def test_what_a_page_cannot_run_is_refused(scenario, controllers, refusal, tmp_path):
    options = EvaluateOptions(scenario, controllers, 2, 0, [], "kinematic")
    with pytest.raises(ConfigError, match=refusal):
        write_playground(options, tmp_path / "x.html")
    assert not (tmp_path / "x.html").exists()


def test_a_policy_that_python_calls_runs_in_no_page(tmp_path, monkeypatch):
    code = "import numpy as np\ndef ahead(seen): return np.zeros((len(seen), 2), np.float32)\n"
    (tmp_path / "my_policy.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    options = EvaluateOptions("es1", ["callable:my_policy:ahead"], 2, 0, [], "kinematic")
    with pytest.raises(ConfigError, match=r"controller 'callable.*': Python calls a layer of it"):
        write_playground(options, tmp_path / "x.html")
