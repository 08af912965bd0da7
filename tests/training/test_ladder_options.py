"""What the commands of the ladder take and refuse; nothing trains."""

import json
from dataclasses import replace

import pytest
import typer
from typer.testing import CliRunner

from swarm_forage_env.errors import ConfigError
from training.ladder import benchmark, cards, commands
from training.ladder.rungs import read_rungs


@pytest.fixture
def call(monkeypatch, tmp_path):
    """Run a command of the ladder, of which nothing is done: its result."""
    app = typer.Typer()
    app.callback()(lambda: None)
    commands.add_benchmark(app)
    monkeypatch.setattr(commands, "find_backend", lambda *given, **named: None)
    monkeypatch.setattr(benchmark, "run_jobs", lambda jobs, out, backend: None)
    monkeypatch.setattr(cards, "score_references", lambda rung, out, backend: {})
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(app, ["benchmark", *words])


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (("cards", "--workers=0"), 2), (("cards", "--workers=1"), 0),
        (("ladder", "--workers=0"), 2), (("ladder", "--workers=1"), 0),
        (("ladder", "--budget=0"), 2), (("ladder", "--budget=1"), 0),
        (("ladder", "--seeds=-1"), 2), (("ladder", "--seeds=0"), 0), ((), 2),
    ],
)  # fmt: skip
def test_numbers_of_commands_have_bounds(call, words, status):
    result = call(*words)
    assert result.exit_code == status, result.output
    assert ("Usage" in result.output) == (status == 2)


def test_without_a_command_all_of_them_are_listed(call):
    shown = call().output
    assert "Missing command" not in shown
    assert all(name in shown for name in ("list", "cards", "ladder", "The ladder: tasks of rising"))


def test_a_rung_without_scores_is_told_of_before_anything_trains(call, monkeypatch):
    name, known = next(iter(read_rungs().items()))
    bare = replace(known, card=known.card.model_copy(update={"scores": {}}))
    monkeypatch.setattr("training.ladder.rungs.read_rungs", lambda: {name: bare})
    made = []
    monkeypatch.setattr(benchmark, "run_jobs", lambda *given: made.append(given))
    assert isinstance(call("ladder", "--seeds=1").exception, ConfigError)
    assert made == []
    assert call("ladder", "--seeds=0").exit_code == 0
    assert len(made) == 1


def test_the_list_in_json_is_one_that_people_can_read(call):
    text = call("list", "--format=json").output
    assert text == json.dumps(json.loads(text), indent=1) + "\n"
