"""Keywords of environments in editors: what a type checker takes is what environments take."""

import re
import subprocess
import sys
from pathlib import Path
from typing import get_args, get_type_hints

import pytest
from beartype.door import is_bearable

from swarm_forage_env import scenarios
from swarm_forage_env.envs import keywords
from swarm_forage_env.envs.config import EnvConfig, PolicyKeywords
from swarm_forage_env.envs.extra_observations import OBSERVATIONS
from swarm_forage_env.envs.observations import LAYER, PREVIOUS
from swarm_forage_env.envs.rewards import REWARDS
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.physics.base import ENGINES
from swarm_forage_env.registry import SCENARIOS
from swarm_forage_env.rendering.viewer import RENDER_MODES
from swarm_forage_env.task import TASKS
from swarm_forage_env.waypoints.scenario import WaypointsScenario

REPOSITORY = Path(__file__).parents[2]

CALLS = Path(__file__).with_name("typed_keywords.py")

BUILT_IN = [TASKS[name] for name in ("foraging", "waypoints", "aggregation")]

NUMBERS = {"n_robots", "duration", "tick"}
"""Of every scenario."""


def names_in(hint):
    """The names of the `Literal` in a type."""
    return {
        name
        for part in get_args(hint)
        for name in ([part] if isinstance(part, str) else names_in(part))
    }


@pytest.mark.parametrize(
    ("checker", "refusal"),
    [
        (["mypy"], r"typed_keywords\.py:(\d+): error"),
        (["basedpyright", "--pythonpath", sys.executable], r"typed_keywords\.py:(\d+):\d+ - error"),
    ],
)
def test_a_type_checker_refuses_misspelt_keywords_of_every_api_and_nothing_else(checker, refusal):
    command = [Path(sys.executable).with_name(checker[0]), *checker[1:], CALLS]
    checked = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    lines = CALLS.read_text(encoding="utf-8").splitlines()
    marked = {number for number, line in enumerate(lines, 1) if "# refused" in line}
    assert set(map(int, re.findall(refusal, checked.stdout))) == marked, checked.stdout


@pytest.mark.parametrize(
    ("options", "fields", "extra"),
    [
        (keywords.PolicyOptions, PolicyKeywords.model_fields, {"learn"}),
        (keywords.EnvOptions, EnvConfig.model_fields, set()),
    ],
)
def test_the_keywords_for_editors_are_those_that_are_validated(options, fields, extra):
    assert set(get_type_hints(options)) - NUMBERS == fields.keys() - extra


@pytest.mark.parametrize("task", BUILT_IN, ids=lambda task: task.name)
def test_the_other_keywords_for_editors_are_numbers_of_every_scenario(task):
    hints, scenario = get_type_hints(keywords.EnvOptions), task.scenario()
    numbers = {"tick": scenario.tick, **scenario.task.model_dump()}
    assert all(is_bearable(numbers[name], hints[name]) for name in NUMBERS)


@pytest.mark.parametrize("name", EnvConfig.model_fields)
def test_each_default_has_the_type_that_an_editor_shows(name):
    hint = get_type_hints(keywords.EnvOptions)[name]
    assert is_bearable(EnvConfig().model_dump()[name], hint)


def test_the_names_that_an_editor_completes_are_those_that_are_registered():
    assert names_in(keywords.Learn) == {name for task in BUILT_IN for name in task.policies}
    assert names_in(keywords.Action) == {name for task in BUILT_IN for name in task.steerings}
    assert names_in(keywords.Observed) == {LAYER, PREVIOUS, *OBSERVATIONS}
    assert names_in(keywords.Physics) == set(ENGINES)
    assert names_in(keywords.Reward) == set(REWARDS)
    assert set(get_args(keywords.RenderMode)) == set(RENDER_MODES)


def test_the_scenarios_that_an_editor_completes_are_those_that_are_registered():
    foraging = {name for name in SCENARIOS if isinstance(SCENARIOS[name], Scenario)}
    waypoints = {name for name in SCENARIOS if isinstance(SCENARIOS[name], WaypointsScenario)}
    assert set(get_args(scenarios.ForagingName)) == foraging
    assert set(get_args(scenarios.WaypointsName)) == waypoints
    assert names_in(scenarios.ScenarioSource) == {*foraging, *waypoints, "aggregation"}
