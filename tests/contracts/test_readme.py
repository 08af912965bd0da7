"""What README and the page on the environment show is run as it stands."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.scenarios import find_scenario

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")


def blocks(language, text=README):
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def run_alone(script):
    environment = {k: v for k, v in os.environ.items() if k != "SWARM_CHECK_SHAPES"}
    command = [sys.executable, "-c", script]
    return subprocess.run(
        command, capture_output=True, text=True, env=environment, cwd=ROOT, check=False
    )


SCRIPTS = [block for block in blocks("python") if block.startswith(("from ", "import "))]
RULE = next(block for block in blocks("python") if block.startswith("@WEIGHTING_RULES"))


@pytest.mark.parametrize("script", SCRIPTS, ids=["train", "gymnasium", "evaluate"])
def test_an_example_runs_and_its_robots_make_round_trips(script):
    run = run_alone("import baselines.controllers\n" + script)
    assert run.returncode == 0, run.stderr
    assert float(run.stdout.split()[-1]) > 0.0


@pytest.mark.parametrize("script", blocks("python", PAGE), ids=["making", "running"])
def test_the_page_on_the_environment_runs(script):
    pytest.importorskip("stable_baselines3")
    run = run_alone(script)
    assert run.returncode == 0, run.stderr


def test_the_scenario_file_is_read(tmp_path):
    (file,) = blocks("toml")
    mine = tmp_path / "mine.toml"
    mine.write_text(file, encoding="utf-8")
    scenario = find_scenario(mine)
    assert (scenario.name, scenario.task.n_robots) == ("mine", 20)
    assert scenario.arena == find_scenario("es1").arena


def test_the_rule_to_add_is_a_rule(monkeypatch):
    monkeypatch.setattr(WEIGHTING_RULES, "_parts", {})
    imports = """
from typing import ClassVar
import numpy as np
from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Encounter
from swarm_forage_env.foraging.scenario import Part
"""
    scope = {"__name__": "average"}
    exec(imports + RULE, scope)
    assert list(WEIGHTING_RULES._parts) == ["average"]
