"""What tells configurations apart."""

import ast
import json
import pickle
from pathlib import Path

import pytest

import swarm_forage_env
from baselines.evaluation import experiment_config
from baselines.evaluation.experiment_config import (
    NOT_HASHED,
    ExperimentConfig,
    find_layered_controller,
    parse_settings,
)
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from tests.scripts import run_python


def test_everything_but_the_seed_changes_the_key(configure):
    variants = [
        *map(configure, ("ssgikf", "ssgiff", "dsgikf", "ssgiff:beta=0.02")),
        configure(physics="rigid"),
        configure(task_duration=30.0),
        configure(radio_loss_far=0.6),
    ]
    assert len({each.key for each in variants}) == len(variants)


def test_a_default_that_is_spelt_out_changes_nothing(configure):
    assert configure("ssgiff:beta=0.01").key == configure("ssgiff").key
    assert configure("ssgiff:weighting.beta=0.02").key == configure("ssgiff:beta=0.020").key


def test_what_was_changed_is_told_as_json(configure):
    configuration = configure("ssgiff:beta=0.02", radio_loss_far=0.6)
    assert json.loads(configuration.parameters) == {"weighting.beta": 0.02}
    assert json.loads(configuration.overrides) == {"radio.loss_far": 0.6, "task.duration": 20.0}
    assert json.loads(configuration.settings)["scenario"]["radio"]["loss_far"] == 0.6
    other = configure("boids-goal:estimator=dead_reckoning")
    assert json.loads(other.parameters) == {"estimator": "dead_reckoning"}
    assert json.loads(other.settings)["controller"]["estimator"] == "dead_reckoning"
    assert other.key != configure("boids-goal").key


RULE = '''
"""A rule."""

GAIN = 1
"""Of the rule."""


class Rule:
    """Weighs."""

    def __call__(self, told):
        """Weigh."""
        return GAIN * told
'''


@pytest.mark.parametrize(
    ("before", "after", "is_same"),
    [
        ('"""A rule."""', '"""A good rule."""', True),
        ('"""Of the rule."""', "", True),
        ('"""Weighs."""', "pass", False),
        ('"""Weigh."""', '"""Weigh what was told."""  # it is little', True),
        ("GAIN = 1", "GAIN = 2", False),
        ("GAIN * told", "told * GAIN", False),
        ("GAIN * told", "(GAIN  *\n told)", True),
    ],
)
def test_other_code_is_another_configuration_and_other_prose_is_not(
    configure, monkeypatch, tmp_path, before, after, is_same
):
    rule, home = tmp_path / "own" / "sums" / "rule.py", tmp_path / "own" / "parts" / "home.py"
    monkeypatch.setattr("baselines.evaluation.experiment_config.getfile", lambda _: str(home))
    for file in (rule, home, rule.with_name("__init__.py"), tmp_path / "own" / "__init__.py"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    rule.write_text(RULE)
    old = configure().key
    rule.write_text(RULE.replace(before, after, 1))
    assert (configure().key == old) == is_same


WORLD = Path(swarm_forage_env.__file__).parent
POLICY = "callable:training.policy:imported,observation=layer+tests.columns:columns"


@pytest.mark.parametrize(
    ("edited", "controller", "is_same"),
    [
        ("device_loop.py", "ssgikf", True),
        ("envs/observations.py", "ssgikf", True),
        ("envs/observations.py", POLICY, False),
        ("../tests/columns.py", POLICY, False),
        ("equations/differential_drive.py", "ssgikf", False),
        ("loop.py", "ssgikf", False),
    ],
)
def test_an_edit_of_what_can_change_a_number_alone_is_another_configuration(
    configure, monkeypatch, edited, controller, is_same
):
    before = configure(controller).key
    content = experiment_config._content

    def as_edited(file):
        return b"edited" if file.samefile(WORLD / edited) else content(file)

    monkeypatch.setattr(experiment_config, "_content", as_edited)
    assert (configure(controller).key == before) is is_same


def imported(file):
    """The names of the files and folders of the world that a file of it imports from."""
    for node in ast.walk(ast.parse(file.read_text())):
        module = (isinstance(node, ast.ImportFrom) and node.module) or ""
        if module.startswith("swarm_forage_env."):
            names = [*module.split(".")[1:], *(each.name for each in node.names)]
            yield from (name + end for name in names for end in ("", ".py"))


ASSEMBLES = {"__init__.py", "task.py", "errors.py", "extras.py", "scene.py", "on_gpu.py"}
"""May name what is not hashed, or be named: lists of all parts, refusals, types of pictures."""


def test_what_is_hashed_calls_nothing_that_is_not():
    inside = {file: set(file.relative_to(WORLD).parts) for file in WORLD.rglob("*.py")}
    for name, reason in NOT_HASHED.items():
        assert reason
        assert any(name in parts for parts in inside.values()), name
    calls = {
        (file.name, name)
        for file, parts in inside.items()
        if NOT_HASHED.keys().isdisjoint(parts)
        for name in NOT_HASHED.keys() & set(imported(file))
    }
    assert [each for each in calls if ASSEMBLES.isdisjoint(each)] == []


@pytest.mark.parametrize("text", ["radio.max_range", "=0.2", "radio.max_range=", "", "="])
def test_a_setting_of_another_form_is_refused(text):
    with pytest.raises(ConfigError, match=r"must be name=value, as in radio\.max_range=0\.2"):
        parse_settings([text])


def test_another_process_tells_the_same_overrides():
    """A worker has imported no scenarios when it is handed its configuration."""
    configuration = ExperimentConfig("nc", find_scenario("es2"), find_layered_controller("nc"))
    program = "import pickle, sys; print(pickle.loads(bytes.fromhex(sys.argv[1])).overrides)"
    output = run_python("-c", program, pickle.dumps(configuration).hex())
    assert output == configuration.overrides == "{}"
