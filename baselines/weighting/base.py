"""The registry of weighting rules; their protocol is `swarm_forage_env.interface.Weighting`."""

from typing import Any

from swarm_forage_env.registry import Registry

WEIGHTING_RULES: Registry[Any] = Registry("weighting rule")
"""Rules by name; each is a `Part` whose fields are its parameters and which is called with an
Encounter."""
