"""The two built-in tasks are known to whoever asks, without an import of their own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    "question",
    [
        "from swarm_forage_env.task import TASKS; TASKS['foraging']; TASKS['waypoints']",
        "from swarm_forage_env.registry import SCENARIOS; SCENARIOS['waypoints-05']",
        "from swarm_forage_env.registry import SCENARIOS; SCENARIOS['es1']",
    ],
)
def test_what_is_built_in_is_there_when_it_is_asked_for(question):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        [sys.executable, "-c", question], env=environment, capture_output=True, text=True,
        check=False, timeout=300,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
