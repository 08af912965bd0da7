"""An outside package, named by its entry point: robots visit three places in turn."""

from patrol import control, task

__all__ = ["control", "task"]
