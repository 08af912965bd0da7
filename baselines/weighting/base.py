"""The registry of weighting rules: parts with a `WeightingLayer`, or a `WeightingRule` in NumPy."""

from typing import Any

from swarm_forage_env.registry import Registry

WEIGHTING_RULES: Registry[Any] = Registry("weighting rule")
"""Rules by name; each is a `Part` whose fields are its parameters. Its method `layer(scenario)`
gives its function, or it is called with what the weighting layer sees."""
