"""Pictures of a world: scenes, still and moving, on a screen, in a file, or as arrays."""

import os

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # it greets on stdout otherwise
