"""The registry of motion rules; their protocol is `swarm_forage_env.interface.Motion`."""

from typing import Any

from swarm_forage_env.registry import Registry

MOTIONS: Registry[Any] = Registry("motion")
"""Parameters by name; each is a `Part` with a method `start(scenario, seeds)`."""
