"""A package of somebody else's: robots that visit three places in turn, as often as they can.

Its entry point, in the group `swarm_forage_env.controllers`, names this package.
"""

from patrol import control, task

__all__ = ["control", "task"]
