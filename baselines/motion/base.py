"""The registry of motion rules: parts with a `MotionLayer`, or that start a `MotionRule`."""

from typing import Any

from swarm_forage_env.registry import Registry

MOTIONS: Registry[Any] = Registry("motion")
"""Rules by name; each is a `Part` whose fields are its parameters. Its method `layer(scenario)`
gives its function, or `start(scenario, seeds)` a rule in NumPy."""
