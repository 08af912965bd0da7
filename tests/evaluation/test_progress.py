"""The bar of a long run counts what is kept, and says what is compiled."""

import pytest

from baselines.evaluation import runner
from baselines.evaluation.backends import JoblibBackend
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.runner import Plan, run_with_progress
from swarm_forage_env import compiler


@pytest.fixture
def plan(tmp_path):
    settings = ["task.duration=20"]
    asked = EvaluateOptions("es1", ["nc", "ssgikf"], 3, 0, settings, "kinematic")
    return asked.plan(tmp_path / "out")


def test_what_is_compiled_is_told_for_which_controller(plan: Plan, monkeypatch):
    def compile_something(configuration):
        for tell in compiler._listeners:
            tell("tick")

    monkeypatch.setattr(runner, "warm_up", compile_something)
    told = []
    list(plan.run(JoblibBackend(), tell=told.append))
    assert told == ["compiling 1 of 2, nc: tick", "compiling 2 of 2, ssgikf: tick", ""]


def test_a_listener_is_told_of_an_entry_point_before_it_is_compiled(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(compiler, "announce", lambda: None)

    def twice_and_three(x):
        return 2 * x + 3

    told = []
    compiled = compiler.entry_point(twice_and_three)
    with compiler.compiling_told(told.append):
        compiled(1.0)
        compiled(2.0)
    assert told == ["twice_and_three"]
    assert compiler._listeners == []


def test_on_a_terminal_the_bar_ends_full(plan: Plan, monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    run_with_progress(plan, JoblibBackend())
    assert "6/6" in capsys.readouterr().err
