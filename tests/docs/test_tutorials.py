"""Every tutorial runs, as a script, at a small budget; and becomes a page."""

import ast

import pytest
import tutorial_pages

from tests.scripts import ROOT, run_python

FOLDER = ROOT / "examples" / "tutorials"
NAMES = sorted(path.stem for path in FOLDER.glob("*.py"))
NEEDS = {
    "a_rule_as_a_package": ("pyarrow", "hatchling"),
    "learn_a_motion": ("stable_baselines3",),
    "learn_a_weighting": ("stable_baselines3",),
    "read_the_data": ("pandas",),
    "reproduce_a_figure": ("matplotlib",),
    "watch_and_compare": ("pygame",),
}


def in_navigation():
    """The tutorials that the site shows, read from its hooks, which need mkdocs to be imported."""
    tree = ast.parse((ROOT / "docs" / "hooks" / "site_hooks.py").read_text(encoding="utf-8"))
    (order,) = (
        each.value
        for each in tree.body
        if isinstance(each, ast.Assign) and ast.unparse(each.targets[0]) == "ORDER"
    )
    return ast.literal_eval(order)


def test_the_site_shows_all_tutorials():
    assert sorted(in_navigation()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_tutorial_runs(name, tmp_path):
    for package in NEEDS.get(name, ()):
        pytest.importorskip(package)
    folder = {"SWARM_FORAGE_TUTORIAL": "small", "SWARM_FORAGE_OUT": str(tmp_path)}
    run_python("-W", "error", FOLDER / f"{name}.py", SWARM_CHECK_SHAPES="", **folder)


@pytest.mark.parametrize("name", NAMES)
def test_the_page_of_a_tutorial_holds_its_text_and_its_code(name):
    script = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    page = tutorial_pages.page(script, name)
    assert page.startswith("# ")
    assert "# %%" not in page
    code = [line for line in script.splitlines() if line and not line.startswith("#")]
    assert all(line in page for line in code)
