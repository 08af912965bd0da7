"""Rendering of a world: live window, images, videos, replays in a browser, arrays and text."""

import os

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # pygame prints a greeting otherwise
