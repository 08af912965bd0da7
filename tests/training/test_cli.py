"""The entry point of the console script, in this process."""

import os
import subprocess
import sys

import pytest

from training import cli


@pytest.fixture
def ended(monkeypatch):
    """How a command ends: its status, and whether stderr was closed."""

    def end(run):
        closed = []
        monkeypatch.setattr("baselines.cli.run", run)
        monkeypatch.setattr(sys, "stderr", sys.__stderr__)
        monkeypatch.setattr(os, "dup2", lambda here, there: closed.append((here, there)))
        with pytest.raises(SystemExit) as stopped:
            cli.main()
        return stopped.value.code, len(closed)

    return end


@pytest.mark.parametrize("status", [0, 1, 2])
def test_the_status_of_a_command_is_that_of_the_script(ended, status):
    assert ended(lambda: status) == (status, 0)


def test_a_command_that_was_interrupted_ends_with_130_and_without_complaints(ended):
    def interrupted():
        raise KeyboardInterrupt

    assert ended(interrupted) == (130, 1)
    assert ended(lambda: 130) == (130, 1)


def test_a_missing_package_is_told_in_the_place_of_a_status(ended):
    def missing():
        raise ModuleNotFoundError("No module named 'cmaes'", name="cmaes")

    assert ended(missing)[0] == (
        "swarm-forage: this command needs 'cmaes': pip install 'swarm-forage[train]'"
    )


def test_commands_are_known_before_the_libraries_that_they_train_with_are_loaded():
    code = (
        "import sys, training.train_command, training.ladder.commands\n"
        "print(*{'torch', 'stable_baselines3', 'training.experiment'} & sys.modules.keys())"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "\n"
