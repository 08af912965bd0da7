"""What holds for every test: array shapes are checked, hypothesis repeats itself."""

import os

# Before any package is imported: `arrays.checked` reads it once.
os.environ["SWARM_CHECK_SHAPES"] = "1"

from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
