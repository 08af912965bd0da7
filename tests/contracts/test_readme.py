"""The code that README, CONTRIBUTING and the page on the environment show runs as printed."""

import importlib.util
import re
import sys
import tomllib

import pytest

from baselines.evaluation.episode import run_episodes
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from tests.scripts import ROOT, run_python

README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")
ARENAS = (ROOT / "docs" / "arenas.md").read_text(encoding="utf-8")
GUIDE = (ROOT / "docs" / "guides" / "weighting.md").read_text(encoding="utf-8")
LINES = 120
"""The README is read in a minute."""


def blocks(language, text=README):
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


(EXAMPLE,) = blocks("python")
RULES = {
    "average": blocks("python", GUIDE)[0],
    "inverse_variance": blocks("python", CONTRIBUTING)[0],
}


def test_the_example_runs():
    printed = run_python("-c", "import baselines.controllers\n" + EXAMPLE)
    assert float(printed.split()[-1]) >= 0.0


def test_the_readme_is_short_and_what_it_links_to_is_there():
    assert len(README.splitlines()) <= LINES
    targets = re.findall(r"\]\(([^)#]+)", README)
    assert len(targets) > 20
    assert not [target for target in targets if not (ROOT / target).is_file()]


def test_the_badges_say_what_the_project_says():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    badge = (ROOT / "docs" / "images" / "badges" / "version.svg").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    bibtex = (ROOT / "docs" / "citing.md").read_text(encoding="utf-8")
    version = project["version"]
    assert f"version {version}" in README
    assert f">{version}<" in badge
    assert f"\nversion: {version}\n" in citation
    assert f"version = {{{version}}}" in bibtex
    assert project["requires-python"] == ">=3.11"


@pytest.mark.parametrize(
    "script",
    blocks("python", PAGE),
    ids=["making", "typed", "batch", "observing", "rewarding", "mixed", "faulty", "running"],
)
def test_the_page_on_the_environment_runs(script):
    pytest.importorskip("stable_baselines3")
    run_python("-c", script)


def test_the_scenario_file_is_read(tmp_path):
    (file,) = blocks("toml")
    mine = tmp_path / "mine.toml"
    mine.write_text(file, encoding="utf-8")
    scenario = find_scenario(mine)
    assert (scenario.name, scenario.task.n_robots) == ("mine", 20)
    assert scenario.arena == find_scenario("es1").arena


@pytest.mark.parametrize("file", blocks("toml", ARENAS), ids=["obstacles", "areas"])
def test_the_files_on_the_page_on_arenas_are_read(tmp_path, file):
    mine = tmp_path / "mine.toml"
    mine.write_text(file, encoding="utf-8")
    scenario = find_scenario(mine)
    assert (len(scenario.obstacles), len(scenario.task.areas)) in {(3, 0), (0, 3)}


@pytest.fixture(params=RULES)
def printed(request, tmp_path, monkeypatch):
    """The name of a rule to add, whose file has just been imported as printed."""
    name = request.param
    file = tmp_path / f"{name}.py"
    file.write_text(RULES[name], encoding="utf-8")
    monkeypatch.setattr(WEIGHTING_RULES, "_parts", dict(WEIGHTING_RULES._parts))
    spec = importlib.util.spec_from_file_location(name, file)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)
    spec.loader.exec_module(module)
    return name


def test_a_rule_to_add_runs_in_a_composition_as_printed(printed):
    controller = find_controller(f"social_odometry+{printed}+subsumption")
    scenario = find_scenario("es1", {"duration": 300.0, "area_distance": 0.62})
    (episode,) = run_episodes(scenario, controller, [0], "kinematic")
    assert episode.controller == f"social_odometry+{printed}+subsumption"
    assert episode.round_trips > 0
    assert "Source: " in WEIGHTING_RULES[printed].__doc__


def test_the_compositions_that_are_named_are_those_of_the_rules_to_add():
    named = re.findall(r"social_odometry\+(\w+)\+subsumption", CONTRIBUTING)
    assert set(named) <= {*RULES, *WEIGHTING_RULES}
    assert set(named) & set(RULES)
