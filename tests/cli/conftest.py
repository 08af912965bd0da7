"""Commands, run in this process or in one of their own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def process(tmp_path):
    """Start a command as a process of its own in an empty folder."""
    started = []

    def start(*arguments, code=None, module="training.cli", variables=None, **options):
        program = ["-c", code] if code else ["-m", module]
        environment = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "80"} | (variables or {})
        environment.pop("SWARM_CHECK_SHAPES", None)
        run = subprocess.Popen(
            [sys.executable, *program, *map(str, arguments)],
            cwd=tmp_path,
            env=environment,
            text=True,
            **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options,
        )
        started.append(run)
        return run

    yield start
    for run in started:
        run.kill()
        run.communicate(timeout=60)
