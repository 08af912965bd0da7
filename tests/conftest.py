"""What holds for every test: shapes are checked, hypothesis repeats itself, no window opens."""

import os

# Before any package is imported: `arrays.checked` reads it once.
os.environ["SWARM_CHECK_SHAPES"] = "1"

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


@pytest.fixture(autouse=True)
def no_display(monkeypatch):
    """No test opens a window on anybody's screen."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
