"""Every tutorial runs, as a script, at a small budget; and the site shows it with its outputs."""

import ast
import json
import re

import pytest
import tutorial_pages

from tests.scripts import ROOT, run_python

FOLDER = ROOT / "examples" / "tutorials"
NAMES = sorted(path.stem for path in FOLDER.glob("*.py"))
SHORT = "--set=task.duration=120"
SHORT_WORLD = {"task.duration": 120.0, "task.area_distance": 0.7}
SMALL = {
    "a_rule_as_a_package": {
        "BUDGET": ["--episodes=1", SHORT, "--workers=1"], "PIP": ["--no-build-isolation"],
    },
    "a_thousand_worlds_on_a_gpu": {"N_WORLDS": 1, "ROBOT_STEPS": 20_000, "BLOCKS": (1, 2)},
    "first_swarm": {"SECONDS": 120.0, "EPISODES": 1},
    "learn_a_motion": {
        "ROBOT_STEPS": 20_000, "N_WORLDS": 2, "BATCH": 640, "TEST_SEEDS": [1000],
        "CHANGES": {"task.duration": 120.0},
    },
    "learn_a_weighting": {
        "EXCHANGES": 128, "N_WORLDS": 1, "ROLLOUT": 64, "BATCH": 640, "TEST_SEEDS": [1000],
        "CHANGES": {"task.duration": 120.0},
    },
    "onto_a_cortex_m4": {"CONTROLLERS": ("nc",), "CHECKED": "nc", "TICKS": 50},
    "read_the_data": {
        "BUDGET": ["--episodes=2", SHORT, "--workers=1"], "FEW": ["--episodes=1", SHORT],
    },
    "reproduce_a_figure": {"EPISODES": 2, "CHANGES": SHORT_WORLD},
    "scale_out": {"STEPS": 5, "BLOCKS": (1, 8), "THREADED": 16},
    "task_in_one_file": {"ROBOT_STEPS": 10_000, "N_WORLDS": 1, "TEST_SEEDS": [1000]},
    "train_in_20_lines": {"STEPS": 5000, "SECONDS": 60, "EPISODES": 1},
    "watch_and_compare": {"SECONDS": 20},
}  # fmt: skip
"""Values of each tutorial's cell of parameters under which its test takes seconds."""


def with_parameters(script, values):
    """The script with other values after its cell of parameters, as papermill has it."""
    head, tag, rest = script.partition('tags=["parameters"]\n')
    cell, mark, after = rest.partition("\n# %%")
    assigned = "".join(f"\n{name} = {value!r}" for name, value in values.items())
    return f"{head}{tag}{cell.rstrip()}{assigned}{mark}{after}"


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
    script = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    file = tmp_path / f"{name}.py"
    file.write_text(with_parameters(script, SMALL[name]), encoding="utf-8")
    run_python("-W", "error", file, cwd=tmp_path, MPLBACKEND="agg")


@pytest.mark.parametrize("name", NAMES)
def test_what_is_kept_of_a_tutorial_is_of_its_code_and_shows_text_and_a_picture(name):
    assert tutorial_pages.is_current(name), "make tutorials"
    kept = (tutorial_pages.KEPT / f"{name}.ipynb").read_text(encoding="utf-8")
    outputs = [each for cell in json.loads(kept)["cells"] for each in cell.get("outputs", ())]
    assert any("text" in each for each in outputs)
    assert any("image/png" in each.get("data", ()) for each in outputs)
    assert not [each for each in outputs if each["output_type"] == "error"]
    assert not re.search(r"['\" ]/(home|root|tmp|Users|work)/", kept), "a path of a machine"
