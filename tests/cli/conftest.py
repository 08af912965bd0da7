"""Commands, run in this process or in one of their own."""

import pytest

import training.ladder.commands
import training.train_command  # noqa: F401 both add their commands
from tests.processes import start


@pytest.fixture
def process(tmp_path):
    """Start a command as a process of its own in an empty folder."""
    started = []

    def command(*arguments, code=None, module="training.cli", variables=None, **options):
        program = ("-c", code) if code else ("-m", module)
        variables = {"COLUMNS": "80", **(variables or {})}
        started.append(start(*program, *arguments, variables=variables, cwd=tmp_path, **options))
        return started[-1]

    yield command
    for run in started:
        run.kill()
        run.communicate(timeout=60)
